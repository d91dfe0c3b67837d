//! The library's glints beside published methods, at the same queries.
//!
//! `cargo test --test glints -- --nocapture` prints the tables, `-- --ignored --nocapture` those of larger samples.
//! Both of ours lead all three in variance over the cases, and in the worst change by a small movement in every one. (Of
//! fewer than 10,001 samples the percentile is the largest.) In the mean they are right, but so are Zirr & Kaplanyan's counts. They do not lead where only a pan is asked for, which the blended cells of two
//! of the methods answer as smoothly; in lights next to each other, which the field slightly opposes (-0.02), no nearer to
//! independent than those of Kemppinen et al.; and the field not in cost, for many flakes
//! (`cargo bench --bench glint_published`).
#![allow(clippy::print_stdout, reason = "tables of figures")]

#[path = "glints/known.rs"]
mod known;
#[path = "glints/measure.rs"]
mod measure;
#[path = "glints/published/mod.rs"]
mod published;

use measure::{Figures, Pops, figures};
use published::Contender;
use published::cases::Case;

const ANISOTROPIES: [f64; 2] = [1.0, 8.0];
const N_EFF: [f64; 3] = [0.1, 1.0, 10.0];

/// A contender in all cases.
struct Row {
    name: &'static str,
    cases: Vec<(Case, Figures)>,
}

impl Row {
    fn new(contender: &Contender, count: u32) -> Self {
        let cases = ANISOTROPIES.iter().flat_map(|&anisotropy| N_EFF.map(|n_eff| Case { n_eff, anisotropy }));
        Self { name: contender.name, cases: cases.map(|case| (case, figures(contender, case, count))).collect() }
    }

    fn most(&self, of: impl Fn(&Figures) -> f64) -> f64 {
        self.cases.iter().map(|(_, f)| of(f)).fold(f64::MIN, f64::max)
    }

    fn least(&self, of: impl Fn(&Figures) -> f64) -> f64 {
        -self.most(|f| -of(f))
    }

    fn print(&self) {
        for (case, f) in &self.cases {
            println!(
                "| {} | {} | {} | {:.3} ± {:.3} | {:.3} ± {:.3} | {} | {} | {} | {:+.3} | {:+.3} |",
                self.name,
                case.n_eff,
                case.anisotropy,
                f.mean[0],
                f.mean[1],
                f.variance[0],
                f.variance[1],
                told(f.pan),
                told(f.zoom),
                told(f.turn),
                f.neighbour,
                f.mirrored
            );
        }
    }

    fn print_worst(&self) {
        let range = |of: fn(&Figures) -> f64| format!("{:.2} to {:.2}", self.least(of), self.most(of));
        let pops =
            |of: fn(&Figures) -> Pops| told(Pops { rare: self.most(|f| of(f).rare), most: self.most(|f| of(f).most) });
        let far = |of: fn(&Figures) -> f64| {
            let (least, most) = (self.least(of), self.most(of));
            if -least > most { least } else { most }
        };
        println!(
            "| {} | {} | {} | {} | {} | {} | {:+.2} | {:+.2} |",
            self.name,
            range(|f| f.mean[0]),
            range(|f| f.variance[0]),
            pops(|f| f.pan),
            pops(|f| f.zoom),
            pops(|f| f.turn),
            far(|f| f.neighbour),
            far(|f| f.mirrored)
        );
    }
}

fn told(pops: Pops) -> String {
    format!("{:.2} ({:.2})", pops.rare, pops.most)
}

fn compare(count: u32) {
    let rows: Vec<_> = Contender::all().iter().map(|contender| Row::new(contender, count)).collect();
    println!("\nOver all cases; changes of 99.99 % of {count} queries (of all), in deviations of g:\n");
    println!("| method | mean | V* | pan 1/256 pixel | zoom 2^(1/256) | turn 1/4096 | next light | mirrored light |");
    println!("|---|---|---|---|---|---|---|---|");
    rows.iter().for_each(Row::print_worst);
    println!("\n| method | N_eff | anisotropy | mean | V* | pan | zoom | turn | next light | mirrored light |");
    println!("|---|---|---|---|---|---|---|---|---|---|");
    rows.iter().for_each(Row::print);
    let [zirr, deliot, kemppinen, field, binomial] = &rows[..] else { panic!("{} rows", rows.len()) };
    let published = [zirr, deliot, kemppinen];

    // Means: three are right within what chance explains, two are not.
    for row in [field, binomial, zirr] {
        assert!(row.most(Figures::bias) < 0.003, "{}: {}", row.name, row.most(Figures::bias));
    }
    assert!(deliot.most(Figures::bias) > 0.05 && kemppinen.most(Figures::bias) > 0.02);

    // Variance: both of ours within a twentieth in every case, each of the others a third off or more in some.
    for row in [field, binomial] {
        assert!(row.most(Figures::variance_off) < 0.05, "{}: {}", row.name, row.most(Figures::variance_off));
    }
    for row in published {
        assert!(row.most(Figures::variance_off) > 0.33, "{}: {}", row.name, row.most(Figures::variance_off));
    }

    // Movement: in every case the worst of both of ours is well below that of each of the others.
    for (ours, margin) in [(field, 2.5), (binomial, 1.7)] {
        for (n, (case, own)) in ours.cases.iter().enumerate() {
            for row in published {
                let (own, theirs) = (own.worst(), row.cases[n].1.worst());
                let told = format!("{case:?}: {} {own:?}, {} {theirs:?}", ours.name, row.name);
                assert!(margin * own.rare < theirs.rare && margin * own.most < theirs.most, "{told}");
            }
        }
        assert!(ours.most(|f| f.worst().most) < 0.3, "{}", ours.name);
        for row in published {
            assert!(row.most(|f| f.worst().rare) > 10.0 * ours.most(|f| f.worst().rare), "{}", row.name);
        }
    }
    // Not where pans alone are asked for: blended cells pan as smoothly as flakes of the field fade.
    for row in [zirr, deliot] {
        assert!(row.most(|f| f.pan.rare) < 0.2, "{}: {}", row.name, row.most(|f| f.pan.rare));
    }

    // Two lights: mirrored ones are the same to one of the methods; all else is within a tenth.
    assert!(deliot.least(|f| f.mirrored) > 0.999);
    for row in &rows {
        let slack = 0.1 + 5.0 / f64::from(count).sqrt();
        assert!(row.most(|f| f.neighbour.abs()) < slack, "{}: {}", row.name, row.most(|f| f.neighbour.abs()));
        assert!(row.name == deliot.name || row.most(|f| f.mirrored.abs()) < slack, "{}", row.name);
    }
}

#[test]
fn the_library_beside_published_methods() {
    compare(10_000);
}

#[test]
#[ignore = "samples of 400000"]
fn the_library_beside_published_methods_at_length() {
    compare(400_000);
}

/// Every contender's query has the number of flakes and the share of the case, by the library's own reckoning.
#[test]
fn queries_ask_for_as_many_flakes_as_they_say() {
    for contender in Contender::all() {
        for n in 0..100 {
            for anisotropy in ANISOTROPIES {
                let q = Case { n_eff: 0.7, anisotropy }.query(contender.tail, n, 6);
                let probe = q.query().probe().unwrap();
                assert!((probe.n_eff() / 0.7 - 1.0).abs() < 1e-3, "{}", probe.n_eff());
                assert!((probe.area / q.share() - 1.0).abs() < 1e-6 && q.share() > 0.0019 && q.share() < 0.0081);
                assert!((probe.kernel.anisotropy() / anisotropy - 1.0).abs() < 1e-3);
            }
        }
    }
}
