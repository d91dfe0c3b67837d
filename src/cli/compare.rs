//! `mipfold compare`.

use rayon::prelude::*;

use super::args::Global;
use super::chains::{Chain, Source};
use super::compare_args::{CompareArgs, FoldChoice};
use super::inputs::{nearest, read_as, single};
use super::judging::{self, Judging, REPORT_FILES, may_report};
use super::lobes_arg::LobesArg;
use super::report::Report;
use super::table::table;
use crate::compare::{Candidate, Limit, Settings};
use crate::error::{Error, Result};
use crate::fold::{self, DEFAULT_FOLD, FOLDS, Fold, Options};
use crate::material::{Earlier, LevelChain, Material, Texels, base_lobes, load, read_folder};
use crate::ndf::{Form, Lobes, lobes_in_words};
use crate::output::Stage;
use crate::report::{ChainAbout, not_this_surface, verdict};

/// Name of the baseline.
const PLAIN: &str = "plain mips";
/// Where it comes from.
pub const PLAIN_SOURCE: &str = "averaged from the surface, as engines do";

pub fn run(args: &CompareArgs, global: &Global, report: &mut Report) -> Result<()> {
    let chains = args.chains.iter().map(|text| Chain::parse(text, &args.reading)).collect::<Result<Vec<_>>>()?;
    if let Some(folder) = &args.output {
        may_report(folder, global.force)?;
    }
    report.progress.set_message("reading");
    let read = chains.par_iter().with_max_len(1).map(Chain::read).collect::<Result<Vec<_>>>()?;
    let (material, base_note) = base(args, &chains, &read)?;
    let settings = args.looking.settings(material.size, &args.reading)?;
    say_base(&material, &base_note, report);
    let (mut candidates, mut about) = (Vec::new(), Vec::new());
    for (chain, read) in chains.iter().zip(read) {
        let size = read.levels[0].size();
        if size != material.size {
            let expected = format!("{}, the size of the surface that it is judged against", material.size);
            return Err(Error::invalid_option(&chain.name, format!("level 0 of {size} texels"), expected));
        }
        say_chain(chain, &read, &base_note, report);
        about.push(ChainAbout {
            source: chain.text.clone(),
            container: read.container.map(|container| container.name()),
            notes: read.level_0.notes,
            warnings: read.level_0.warnings,
        });
        candidates.push(Candidate { name: chain.name.clone(), fold: read.fold, levels: read.levels });
    }
    let folds = folds(args, &material)?;
    candidates.extend(folds.into_iter().map(|(fold, lobes)| {
        // A mixture is another fold than its one lobe; how many widths it has stands beside the name.
        let name = fold.name.to_owned() + &lobes_in_words(Form::Isotropic, lobes.count(), lobes.shared_normal());
        folded(&name, &material, fold, lobes)
    }));
    let of_surface = |source: &str| ChainAbout { source: source.into(), ..ChainAbout::default() };
    about.resize(candidates.len(), of_surface("folded from the surface"));
    check_limits(&args.limit, &candidates, &settings, material.size.level_count())?;
    let plain = (!args.no_plain).then_some(candidates.len());
    if !args.no_plain {
        candidates.push(plain_mips(&material)?);
        about.push(of_surface(PLAIN_SOURCE));
    }
    distinct_names(&mut candidates);
    let judging = Judging {
        material: &material,
        candidates: &candidates,
        about: &about,
        plain,
        settings: &settings,
        limits: &args.limit,
        motion: !args.no_motion && args.output.is_some(),
    };
    if global.dry_run {
        judging.announce(args.output.as_deref(), report);
        return Ok(());
    }
    let findings = judging.run(report)?;
    let subject = judging.subject(&findings);
    subject.judgement.chains.iter().for_each(|chain| report.say(&table(chain)));
    match not_this_surface(&subject) {
        Some(warning) => report.warning(&warning),
        None => report.say(&verdict(&subject).text),
    }
    report.document(crate::report::json(&subject));
    if let Some(folder) = &args.output {
        let texts = judging::texts(&subject, report)?;
        let stage = Stage::new(folder)?;
        judging::write(&texts, &stage)?;
        stage.commit(REPORT_FILES[0], &[])?;
        report.say(&format!("wrote {} to {}", REPORT_FILES.join(", "), folder.display()));
    }
    judging::failures(&subject).iter().for_each(|line| report.failure(line));
    Ok(())
}

/// The surface that is judged against, and where it comes from.
fn base(args: &CompareArgs, chains: &[Chain], read: &[LevelChain]) -> Result<(Material, String)> {
    let (maps, reading) = (&args.maps, &args.reading);
    if let Some(path) = &args.base {
        let sets = match nearest(path, maps, reading) {
            // What a build wrote is no texture set, but has a level 0.
            Err(_) if Earlier::read(path).is_some() => {
                return Ok((read_folder(path, None)?.level_0, format!("level 0 of {}", path.display())));
            }
            sets => sets?.into_iter().collect::<Result<Vec<_>>>()?,
        };
        let names = sets.iter().map(|set| set.name.clone()).collect::<Vec<_>>().join(", ");
        let count = sets.len();
        let mut sets = sets.into_iter();
        return match (sets.next(), sets.next()) {
            (Some(set), None) => Ok((load(&read_as(set, maps, reading)?)?, format!("the maps of {}", path.display()))),
            _ => Err(Error::invalid(
                path,
                format!("{count} materials: {names}"),
                "one; name its maps with --normal and --roughness, or its folder",
            )),
        };
    }
    let width = maps.roughness.is_some() || maps.gloss.is_some() || maps.orm.is_some();
    if maps.normal.is_some() || maps.height.is_some() || maps.anisotropy.is_some() || width {
        let set = single(maps, reading, "compare")?;
        return Ok((load(&read_as(set, maps, reading)?)?, "the maps given".into()));
    }
    let built = chains.iter().position(|chain| matches!(chain.source, Source::Folder(..)));
    let first = built.or(if chains.is_empty() { None } else { Some(0) });
    let Some(first) = first else {
        let expected = "a CHAIN, --base FOLDER, or the maps of level 0: --normal FILE --roughness FILE";
        return Err(Error::invalid_option("compare", "nothing to judge", expected));
    };
    let mut material = read[first].level_0.clone();
    if let Some(name) = &maps.name {
        material.name = name.clone();
    }
    Ok((material, format!("level 0 of {}", chains[first].name)))
}

fn say_base(material: &Material, origin: &str, report: &Report) {
    report.say(&format!("{}: {}, judged against {origin}", material.name, material.size));
    material.notes.iter().for_each(|note| report.say(&format!("  {note}")));
    material.warnings.iter().for_each(|warning| report.warning(&format!("{}: {warning}", material.name)));
}

/// What was understood of a chain, unless it was said of the surface.
fn say_chain(chain: &Chain, read: &LevelChain, base: &str, report: &Report) {
    let fold = read.fold.as_ref().map(|fold| format!(", fold {fold}")).unwrap_or_default();
    report.say(&format!("{}: {} levels{fold}", chain.name, read.levels.len()));
    // Of a folder the build has told.
    if *base != format!("level 0 of {}", chain.name) && !matches!(chain.source, Source::Folder(..)) {
        read.level_0.notes.iter().for_each(|note| report.say(&format!("  {note}")));
        read.level_0.warnings.iter().for_each(|warning| report.warning(&format!("{}: {warning}", chain.name)));
    }
}

/// A limit that covers no level which is judged would never fail, and a chain without one would pass unseen.
fn check_limits(limits: &[Limit], chains: &[Candidate], settings: &Settings, count: usize) -> Result<()> {
    for chain in chains {
        let (name, last) = (&chain.name, chain.levels.len() - 1);
        let judged: Vec<usize> =
            (0..=last).filter(|k| settings.levels.is_empty() || settings.levels.contains(k)).collect();
        if judged.is_empty() {
            let wanted = settings.levels.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
            let found = format!("levels 0 to {last}, of which none is judged");
            return Err(Error::invalid_option(name, found, format!("one of --levels {wanted}")));
        }
        let wanted = |level: usize| settings.levels.is_empty() || settings.levels.contains(&level);
        let passes_unseen = |limit: &&Limit| {
            let named = limit.levels.as_ref().is_some_and(|levels| *levels.end() < usize::MAX);
            // Level 0 is the input again, and passes by itself: it counts where it was asked for.
            let counts = |level: usize| level > 0 || named || settings.levels.contains(&0);
            let seen = judged.iter().any(|level| limit.covers(*level) && counts(*level));
            let missing = (last + 1..count).any(|level| wanted(level) && limit.covers(level));
            !seen || (named && missing)
        };
        if let Some(limit) = limits.iter().find(passes_unseen) {
            let found = format!("levels of '{name}' that it covers and that are not there or not judged");
            let judged = judged.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
            let expected = format!("a level that is judged: {judged} ('{name}' has levels 0 to {last})");
            return Err(Error::invalid_option(format!("--limit {limit}"), found, expected));
        }
    }
    Ok(())
}

/// The folds to judge, each with its lobes.
fn folds(args: &CompareArgs, material: &Material) -> Result<Vec<(&'static Fold, LobesArg)>> {
    let mut folds: Vec<&'static Fold> = Vec::new();
    let mut add = |fold: &'static Fold| {
        if !folds.iter().any(|other| other.name == fold.name) {
            folds.push(fold);
        }
    };
    let average = Fold::by_name("average")?;
    for choice in &args.fold {
        match choice {
            FoldChoice::One(fold) => {
                if let Some(lobes) = args.lobes {
                    lobes.check(fold)?;
                }
                add(fold);
            }
            // Plain mips are the same, and judged anyway.
            FoldChoice::All => {
                let folds = FOLDS.iter().filter(|f| !f.is_slow());
                folds.filter(|f| args.no_plain || f.name != average.name).for_each(&mut add);
            }
        }
    }
    if folds.is_empty() && args.lobes.is_some() && !args.chains.is_empty() {
        let expected = "--fold NAME beside it, whose lobes it says; those of a CHAIN are its own";
        return Err(Error::invalid_option("--lobes", "no --fold", expected));
    }
    if folds.is_empty() && args.chains.is_empty() {
        args.lobes.map_or(Ok(()), |lobes| lobes.check(DEFAULT_FOLD))?;
        folds.push(DEFAULT_FOLD);
    }
    let usual = if material.is_anisotropic() { LobesArg::Aniso } else { LobesArg::Iso };
    let wanted = args.lobes.unwrap_or(usual);
    // Of all folds, those that cannot have it give what they can.
    let lobes = |fold: &Fold| {
        let plainer = if wanted.form() == Form::Anisotropic { LobesArg::Aniso } else { LobesArg::Iso };
        [wanted, plainer].into_iter().find(|lobes| lobes.fits(fold)).unwrap_or(LobesArg::Iso)
    };
    Ok(folds.into_iter().map(|fold| (fold, lobes(fold))).collect())
}

/// A fold of the surface.
fn folded(name: &str, material: &Material, fold: &'static Fold, lobes: LobesArg) -> Candidate {
    let (form, count, shared_normal) = (lobes.form(), lobes.count(), lobes.shared_normal());
    let options = Options { fold, form, lobes: count, shared_normal, ..Options::default() };
    let levels = levels(material, fold::chain(material, &options), form);
    let fold = fold.name.to_owned() + &lobes_in_words(form, count, shared_normal);
    Candidate { name: name.into(), fold: Some(fold), levels }
}

/// What engines make of the surface.
pub fn plain_mips(material: &Material) -> Result<Candidate> {
    Ok(folded(PLAIN, material, Fold::by_name("average")?, LobesArg::Iso))
}

/// All levels as lobes, the finest first. A surface of two widths keeps them at level 0, whatever the fold has.
pub fn levels(material: &Material, chain: fold::Chain, form: Form) -> Vec<Lobes> {
    let form = if material.is_anisotropic() { Form::Anisotropic } else { form };
    chain.into_lobes(base_lobes(material, form)).into_iter().map(|lobes| lobes.in_form(form)).collect()
}

/// Names that stand for one chain each.
fn distinct_names(chains: &mut [Candidate]) {
    for i in 1..chains.len() {
        let (mut name, mut n) = (chains[i].name.clone(), 2);
        while chains[..i].iter().any(|other| other.name == name) {
            name = format!("{} {n}", chains[i].name);
            n += 1;
        }
        chains[i].name = name;
    }
}
