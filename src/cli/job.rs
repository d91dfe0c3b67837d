//! One material from inputs to files.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use indicatif::ProgressBar;

use super::glint_args::FlakeArgs;
use super::report::{Built, Extent, Portion};
use crate::curvature::{BakeOptions, Mesh, Summary, bake, check};
use crate::error::Result;
use crate::fold::{Chain, Options};
use crate::material::{Earlier, Extra, Inputs, Material, MeshAbout, MeshUnder, ReadPicture, Texels, load_with};
use crate::ndf::Form;
use crate::output::{MANIFEST, Plan, Request, fold_for, gain, write_with};

/// What to build, and how.
pub struct Job<'a> {
    pub inputs: &'a Inputs,
    pub read: ReadPicture<'a>,
    /// The mesh under the texture, if its curvature is to be baked.
    pub under: Option<Under<'a>>,
    /// Flakes on the surface, if it is to have any.
    pub flakes: Option<&'a FlakeArgs>,
    /// Makes the pictures of the request.
    pub draw: Option<Draw<'a>>,
    pub options: &'a Options,
    /// One width or two; if it was not said, two where the inputs are anisotropic.
    pub form: Option<Form>,
    pub request: &'a Request,
    /// Nothing is written where folding changes the roughness by less than this.
    pub skip_if_below: Option<f32>,
}

/// Makes the files of pictures of a folded material.
pub type Draw<'a> = &'a dyn Fn(&Material, &Chain) -> Vec<Vec<u8>>;

/// A mesh under a texture.
pub struct Under<'a> {
    pub mesh: &'a Mesh,
    /// Where it came from.
    pub file: &'a Path,
    /// Of the file, hexadecimal.
    pub sha256: &'a str,
    pub uv_set: usize,
    pub options: BakeOptions,
}

/// A warning about a mesh.
pub const NORMALS_COMPUTED: &str =
    "the mesh lacks normals: computed, with an edge where faces meet at a large angle (--crease)";

/// A material after its build.
pub struct Done {
    pub material: Material,
    /// As it was folded.
    pub options: Options,
    /// Absent in a dry run.
    pub chain: Option<Chain>,
    pub built: Built,
}

impl Job<'_> {
    /// Of the bar, for folding and writing.
    pub const STEPS: u64 = 2 * Portion::STEPS;

    /// Reads, folds and writes the material; a dry run stops before folding.
    pub fn run(&self, dry_run: bool, bar: &ProgressBar) -> Result<Done> {
        let (name, request) = (&self.inputs.name, self.request);
        bar.set_message(format!("reading {name}"));
        let mut material = load_with(&request.inputs(self.inputs), self.read)?;
        let options = Options { form: self.choose_form(&mut material), ..*self.options };
        if options.form == Form::Anisotropic {
            material.ensure_anisotropy_map();
        }
        request.extras.iter().try_for_each(|extra| extra.check(options.form, options.lobes))?;
        let mut request = request.clone();
        if let Some(flakes) = self.flakes {
            let flakes = material.flakes.insert(flakes.load(material.size, material.wrap, self.read)?);
            request.extras.extend((!flakes.levels.is_empty()).then_some(Extra::Flakes));
        }
        let request = &request;
        let plan = Plan::new(&material, &options, request);
        plan.check(&material, request)?;
        if let Some(under) = &self.under {
            bar.set_message(format!("baking {name}"));
            let portion = Portion::on(bar);
            under.bake_into(&mut material, dry_run, &|share| portion.show(share))?;
        }
        let files = plan.outputs.iter().map(|o| o.name.clone()).chain([MANIFEST.to_owned()]).collect();
        let mut built = Built {
            name: material.name.clone(),
            folder: request.folder.to_string_lossy().into_owned(),
            extent: Extent::Texture {
                width: material.size.width,
                height: material.size.height,
                levels: material.size.level_count(),
                fold: options.fold.name,
            },
            files,
            maps: Vec::new(),
            notes: material.notes.clone(),
            warnings: material.warnings.iter().chain(&plan.warnings).cloned().collect(),
            gain: None,
            skipped: false,
        };
        if dry_run {
            return Ok(Done { material, options, chain: None, built });
        }
        let (folding, writing) = (Portion::on(bar), Portion::on(bar));
        bar.set_message(format!("folding {name}"));
        let chain = fold_for(&material, &options, &request.extras, &|share| folding.show(share));
        folding.show(1.0);
        let gain = gain(&chain);
        built.gain = Some(gain);
        if self.skip_if_below.is_some_and(|least| gain.roughness < least) {
            built.skipped = true;
            if Earlier::read(&request.folder).is_some_and(|earlier| earlier.material == material.name) {
                built.warnings.push(format!("what an earlier build left in {} is still there", built.folder));
            }
            built.files.clear();
            writing.show(1.0);
            return Ok(Done { material, options, chain: Some(chain), built });
        }
        let pictures = self.draw.map_or_else(Vec::new, |draw| draw(&material, &chain));
        bar.set_message(format!("writing {name}"));
        let (files, written) = (plan.outputs.len(), AtomicUsize::new(0));
        let tell = || writing.show((written.fetch_add(1, Ordering::Relaxed) + 1) as f64 / files as f64);
        write_with(&material, &chain, &options, &plan, request, &pictures, &tell)?;
        Ok(Done { material, options, chain: Some(chain), built })
    }

    /// Two widths, unless asked otherwise, for a material that brings anisotropy: one width would lose it.
    fn choose_form(&self, material: &mut Material) -> Form {
        let defined = self.options.fold.has_two_widths();
        match self.form {
            Some(Form::Isotropic) if material.is_anisotropic() => {
                material.warnings.push("one width loses the anisotropy map from level 1 on; see --lobes aniso".into());
                Form::Isotropic
            }
            Some(form) => form,
            None if material.is_anisotropic() && defined => {
                material.notes.push("folded to two widths, for there is an anisotropy map; see --lobes".into());
                Form::Anisotropic
            }
            None => {
                if material.is_anisotropic() {
                    let name = self.options.fold.name;
                    let warning = format!("fold {name} has one width and loses the anisotropy map from level 1 on");
                    material.warnings.push(warning);
                }
                Form::Isotropic
            }
        }
    }
}

impl Under<'_> {
    /// Bakes the curvature into the material's size, and notes what was found. A dry run only finds out whether it can be.
    fn bake_into(&self, material: &mut Material, dry_run: bool, done: &(dyn Fn(f64) + Sync)) -> Result<()> {
        let mut about = MeshAbout {
            path: self.file.to_string_lossy().into_owned(),
            sha256: self.sha256.to_owned(),
            uv_set: self.uv_set,
            padding: self.options.padding,
            triangles: self.mesh.triangles.len(),
        };
        let mut added = Vec::new();
        if self.mesh.normals_computed {
            material.warnings.push(NORMALS_COMPUTED.into());
        }
        if dry_run {
            check(self.mesh, material.size)?;
        } else {
            let baked = bake(self.mesh, material.size, &self.options, done)?;
            let Summary { triangles, islands, left_out, covered, overlapped, .. } = baked.summary;
            (about.triangles, added) = (triangles, baked.levels);
            let file = self.file.file_name().unwrap_or_default().to_string_lossy();
            let note = format!("curvature of {triangles} triangles of {file}, {islands} islands, from level 1 on");
            material.notes.push(note);
            if left_out > 0.005 {
                let share = 100.0 * left_out;
                let warning = format!("{share:.1} % of the surface has no place in the texture, and is left out");
                material.warnings.push(warning);
            }
            if 10 * overlapped > covered {
                let share = 100.0 * overlapped as f64 / covered as f64;
                let note = format!("surfaces lie on each other in {share:.0} % of the texels: their mean is baked");
                material.notes.push(note);
            }
        }
        material.mesh = Some(MeshUnder { about, added });
        Ok(())
    }
}
