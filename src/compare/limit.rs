//! How far is too far.

use std::fmt;
use std::ops::RangeInclusive;
use std::str::FromStr;

use serde::{Serialize, Serializer};

use super::{ChainScore, LevelScore};

/// A figure of a level that can be limited.
#[derive(Clone, Copy, Debug)]
pub struct Metric {
    /// On the command line and in reports.
    pub name: &'static str,
    /// One line for people.
    pub about: &'static str,
    /// Mean and standard error of a level; 0 is right.
    pub read: fn(&LevelScore) -> (f64, f64),
}

impl Metric {
    /// Every metric, the headline first.
    pub const ALL: &[Metric] = &[
        Metric {
            name: "lobe-error",
            about: "specular lobe as seen from five views under all lights, 0 same, 2 disjoint",
            read: |level| (level.lobe_error.mean, level.lobe_error.stderr),
        },
        Metric {
            name: "light-error",
            about: "the same under a round light of 5 degrees radius",
            read: |level| (level.lobe_error_light.mean, level.lobe_error_light.stderr),
        },
        Metric {
            name: "ndf-tv",
            about: "total variation between the distributions of normals, 0 same, 1 disjoint",
            read: |level| (level.ndf_tv.mean, level.ndf_tv.stderr),
        },
        Metric {
            name: "diffuse-error",
            about: "diffuse light, 0 same",
            read: |level| (level.diffuse_error.mean, level.diffuse_error.stderr),
        },
        Metric {
            name: "energy",
            about: "reflected energy, distance of its ratio to the truth from 1",
            read: |level| ((level.energy.mean - 1.0).abs(), level.energy.stderr),
        },
    ];
}

/// Names are unique.
impl PartialEq for Metric {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Serialize for Metric {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name)
    }
}

/// A largest mean of a metric, for some levels or for all.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Limit {
    /// Of which figure.
    pub metric: Metric,
    /// For which levels; all if `None`.
    pub levels: Option<RangeInclusive<usize>>,
    /// The largest mean that passes.
    pub most: f64,
}

impl Limit {
    /// A limit of the lobe error at every level.
    pub fn lobe_error(most: f64) -> Self {
        Self { metric: Metric::ALL[0], levels: None, most }
    }

    /// Whether it holds for a level.
    pub fn covers(&self, level: usize) -> bool {
        self.levels.as_ref().is_none_or(|levels| levels.contains(&level))
    }
}

/// `0.15`, `ndf-tv=0.1`, `lobe-error@3=0.2`, `lobe-error@1-4=0.1` or `@2-=0.3`.
impl FromStr for Limit {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || {
            let names: Vec<_> = Metric::ALL.iter().map(|m| m.name).collect();
            format!("expected NUMBER or METRIC[@LEVELS]=NUMBER, METRIC one of {}", names.join(", "))
        };
        let (what, most) = text.rsplit_once('=').unwrap_or(("", text));
        let (name, levels) = what.split_once('@').map_or((what, None), |(name, levels)| (name, Some(levels)));
        let name = if name.is_empty() { Metric::ALL[0].name } else { name };
        let metric = *Metric::ALL.iter().find(|metric| metric.name == name).ok_or_else(expected)?;
        let levels = levels.map(|levels| level_range(levels).ok_or_else(expected)).transpose()?;
        let most = most.parse().ok().filter(|most: &f64| *most >= 0.0 && most.is_finite()).ok_or_else(expected)?;
        Ok(Self { metric, levels, most })
    }
}

/// As it is read.
impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.metric.name)?;
        if let Some(levels) = &self.levels {
            match (levels.start(), levels.end()) {
                (first, &usize::MAX) => write!(f, "@{first}-")?,
                (first, last) if first == last => write!(f, "@{first}")?,
                (first, last) => write!(f, "@{first}-{last}")?,
            }
        }
        write!(f, "={}", self.most)
    }
}

/// `3`, `1-4`, or `2-`, which has no end. Nothing where it is none of these, or ends before it begins.
pub(crate) fn level_range(text: &str) -> Option<RangeInclusive<usize>> {
    let number = |text: &str| text.parse::<usize>().ok();
    let (first, last) = match text.split_once('-') {
        None => (number(text)?, number(text)?),
        Some((first, "")) => (number(first)?, usize::MAX),
        Some((first, last)) => (number(first)?, number(last)?),
    };
    (first <= last).then_some(first..=last)
}

/// A level past a limit.
#[derive(Clone, Debug, PartialEq)]
pub struct Breach {
    /// Name of the chain.
    pub chain: String,
    /// Its level.
    pub level: usize,
    /// The limit.
    pub limit: Limit,
    /// What was found.
    pub mean: f64,
    /// Standard error of what was found.
    pub stderr: f64,
}

impl fmt::Display for Breach {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { chain, level, limit, mean, stderr } = self;
        let (name, most) = (limit.metric.name, limit.most);
        if mean.is_nan() {
            return write!(f, "{chain}: level {level}: {name} was not judged, the limit is {most}");
        }
        // Two digits of what is over, however little it is.
        let over = mean - most;
        let digits = if over > 0.0 { (1.0 - over.log10().floor()).clamp(3.0, 12.0) as usize } else { 3 };
        write!(f, "{chain}: level {level}: {name} {mean:.digits$} +- {stderr:.digits$}, ")?;
        write!(f, "{over:.digits$} over the limit {most}")
    }
}

impl std::error::Error for Breach {}

impl ChainScore {
    /// Whether every level keeps the limits: what a test of an engine asks.
    ///
    /// # Errors
    /// The worst breach, whose text names the level and the excess.
    pub fn keeps(&self, limits: &[Limit]) -> Result<(), Breach> {
        self.breaches(limits).into_iter().next().map_or(Ok(()), Err)
    }

    /// Every level past a limit, the furthest past its limit first. A limit that holds for no judged level is past too,
    /// with a mean that is not a number: what nobody looked at has not passed.
    pub fn breaches(&self, limits: &[Limit]) -> Vec<Breach> {
        let mut found: Vec<Breach> = Vec::new();
        for limit in limits {
            let chain = || self.name.clone();
            let mut covered = self.levels.iter().filter(|level| limit.covers(level.level)).peekable();
            if covered.peek().is_none() {
                let level = limit.levels.as_ref().map_or(0, |levels| *levels.start());
                found.push(Breach { chain: chain(), level, limit: limit.clone(), mean: f64::NAN, stderr: f64::NAN });
            }
            for level in covered {
                let (mean, stderr) = (limit.metric.read)(level);
                if mean.is_nan() || mean > limit.most {
                    found.push(Breach { chain: chain(), level: level.level, limit: limit.clone(), mean, stderr });
                }
            }
        }
        found.sort_by(|a, b| (b.mean - b.limit.most).total_cmp(&(a.mean - a.limit.most)));
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_read_as_written() {
        let read = |text: &str| {
            let Limit { metric, levels, most } = text.parse().unwrap();
            (metric.name, levels, most)
        };
        assert_eq!(read("0.15"), ("lobe-error", None, 0.15));
        assert_eq!(read("ndf-tv=0.1"), ("ndf-tv", None, 0.1));
        assert_eq!(read("energy@3=0"), ("energy", Some(3..=3), 0.0));
        assert_eq!(read("@1-4=1e-2"), ("lobe-error", Some(1..=4), 0.01));
        assert_eq!(read("diffuse-error@2-=2"), ("diffuse-error", Some(2..=usize::MAX), 2.0));
        for wrong in ["", "x", "-1", "nan", "tv=1", "lobe-error@=1", "lobe-error@x=1", "lobe-error@1-2-3=1", "@4-1=1"] {
            assert!(wrong.parse::<Limit>().is_err(), "{wrong}");
        }
        for text in ["lobe-error=0.15", "energy@3=0", "ndf-tv@1-4=0.01", "diffuse-error@2-=2"] {
            assert_eq!(text.parse::<Limit>().unwrap().to_string(), text);
        }
    }

    #[test]
    fn breaches_name_the_level_and_the_excess() {
        let level = |level, mean| {
            let lobe_error = super::super::Summary { mean, stderr: 0.01, ..Default::default() };
            LevelScore { level, lobe_error, ..Default::default() }
        };
        let chain = ChainScore {
            name: "mine".into(),
            fold: None,
            lobes: crate::ndf::Form::Isotropic,
            count: 1,
            levels: vec![level(0, 0.0), level(1, 0.2), level(2, 0.5), level(3, f64::NAN)],
        };
        let breaches = chain.breaches(&["0.3".parse().unwrap(), "@1=0.1".parse().unwrap()]);
        let levels: Vec<_> = breaches.iter().map(|b| b.level).collect();
        assert_eq!(levels, [3, 2, 1]);
        assert_eq!(breaches[1].to_string(), "mine: level 2: lobe-error 0.500 +- 0.010, 0.200 over the limit 0.3");
        assert_eq!(chain.keeps(&[Limit::lobe_error(0.3)]).unwrap_err().level, 3);
        let fine: LevelScore = level(4, 0.300_012);
        let close = ChainScore { levels: vec![fine], ..chain.clone() };
        let breach = close.keeps(&[Limit::lobe_error(0.3)]).unwrap_err().to_string();
        assert_eq!(breach, "mine: level 4: lobe-error 0.300012 +- 0.010000, 0.000012 over the limit 0.3");
        let unseen = chain.keeps(&["@5=1".parse().unwrap()]).unwrap_err().to_string();
        assert_eq!(unseen, "mine: level 5: lobe-error was not judged, the limit is 1");
        assert!(chain.breaches(&["ndf-tv=0.3".parse().unwrap()]).is_empty());
    }
}
