//! Shader helpers: functions to include in shaders, in three languages.
//!
//! `kernels/wgsl` is written by hand. `kernels/glsl` and `kernels/hlsl` are made from it, line by line, with names and
//! comments; the tests in `tests/gpu` do that, and run all three against [`twins`]. A helper's text says what its functions
//! take and give, in which units and ranges, and whom a formula is after.

pub mod twins;

use crate::error::{Error, Result};

/// What shaders are written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Language {
    /// WGSL, as wgpu and Bevy take it.
    Wgsl,
    /// GLSL, for versions 450, 330 and ES 3.00.
    Glsl,
    /// HLSL.
    Hlsl,
}

/// A file of helpers.
#[derive(Debug)]
pub struct Kernel {
    /// Name of the file, without its ending.
    pub name: &'static str,
    /// What is in it, in one line.
    pub about: &'static str,
    /// By language.
    texts: [&'static str; 3],
}

macro_rules! kernel {
    ($name:literal, $about:literal) => {
        Kernel {
            name: $name,
            about: $about,
            texts: [
                include_str!(concat!("../../kernels/wgsl/", $name, ".wgsl")),
                include_str!(concat!("../../kernels/glsl/", $name, ".glsl")),
                include_str!(concat!("../../kernels/hlsl/", $name, ".hlsl")),
            ],
        }
    };
}

/// Every file; each needs only files that stand before it.
pub static KERNELS: &[Kernel] = &[
    kernel!("roughness", "units and forms of width: alpha, perceptual, kappa, glTF and Burley anisotropy; Toksvig"),
    kernel!("moments", "reading what `build` writes; LEAN and LEADR moments at run time"),
    kernel!("ndf", "GGX, Beckmann and Student-t distributions, Smith masking, sampling"),
    kernel!("shading", "specular and diffuse terms, energy compensation, bent reflections"),
    kernel!("geometric_aa", "geometric filtering after Kaplanyan and Tokuyoshi, derivatives as arguments"),
    kernel!("geometric_aa_screen", "the same with the screen's derivatives, for fragment shaders"),
    kernel!("glint_chance", "hashes, normal quantile and error function, binomial and Poisson counts"),
    kernel!("glint", "flakes: the chart of a lobe, a pixel and a light in units of flakes"),
    kernel!("glint_field", "the glint ratio as the sum over a pixel's own flakes"),
    kernel!("glint_binomial", "the glint ratio from counts in cells, after Zirr and Kaplanyan"),
    kernel!("footprint", "the one call: mip chain, curvature and glints to the lobe to shade with"),
];

impl Kernel {
    /// The file's text.
    pub fn text(&self, language: Language) -> &'static str {
        self.texts[match language {
            Language::Wgsl => 0,
            Language::Glsl => 1,
            Language::Hlsl => 2,
        }]
    }

    /// The files that it needs, and those that they need, each after those that it needs itself.
    pub fn needs(&self) -> Vec<&'static Kernel> {
        let direct = |kernel: &Kernel| -> Vec<&'static str> {
            let line = kernel.text(Language::Wgsl).lines().find_map(|line| line.strip_prefix("// Needs: "));
            line.map_or(vec![], |line| line.split(", ").filter(|name| *name != "nothing").collect())
        };
        let mut names = direct(self);
        let mut next = 0;
        while next < names.len() {
            let further = KERNELS.iter().find(|kernel| kernel.name == names[next]).map_or(vec![], direct);
            names.extend(further);
            next += 1;
        }
        KERNELS.iter().filter(|kernel| names.contains(&kernel.name)).collect()
    }
}

/// The file of this name.
///
/// # Errors
/// [`Error::Invalid`] with the list of names.
pub fn by_name(name: &str) -> Result<&'static Kernel> {
    KERNELS.iter().find(|kernel| kernel.name == name).ok_or_else(|| {
        let names: Vec<_> = KERNELS.iter().map(|kernel| kernel.name).collect();
        Error::invalid_option("kernels", format!("no file '{name}'"), format!("one of {}", names.join(", ")))
    })
}

/// One text of some files and of all that they need, each once.
pub fn bundle(kernels: &[&'static Kernel], language: Language) -> String {
    let needed: Vec<&str> = kernels.iter().flat_map(|kernel| kernel.needs()).map(|kernel| kernel.name).collect();
    let asked = |kernel: &Kernel| kernels.iter().any(|other| other.name == kernel.name);
    let texts = KERNELS.iter().filter(|kernel| asked(kernel) || needed.contains(&kernel.name));
    texts.map(|kernel| kernel.text(language)).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names of the functions that a text defines, in WGSL.
    fn functions(text: &str) -> Vec<&str> {
        text.lines().filter_map(|line| line.strip_prefix("fn ")?.split('(').next()).collect()
    }

    #[test]
    fn each_file_needs_only_files_before_it_and_is_bundled_once() {
        for (at, kernel) in KERNELS.iter().enumerate() {
            let text = kernel.text(Language::Wgsl);
            let line = text.lines().find_map(|line| line.strip_prefix("// Needs: ")).expect(kernel.name);
            for name in line.split(", ").filter(|name| *name != "nothing") {
                assert!(KERNELS[..at].iter().any(|earlier| earlier.name == name), "{} needs {name}", kernel.name);
            }
            let bundled = bundle(&[kernel], Language::Wgsl);
            let mut names = functions(&bundled);
            assert!(functions(text).iter().all(|name| names.contains(name)), "{}", kernel.name);
            for needed in kernel.needs() {
                assert!(functions(needed.text(Language::Wgsl)).iter().all(|name| names.contains(name)));
            }
            let count = names.len();
            names.sort_unstable();
            names.dedup();
            assert_eq!(names.len(), count, "{}", kernel.name);
        }
    }

    #[test]
    fn the_list_is_that_of_the_folder_and_all_languages_have_the_same_functions() {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("kernels");
        for ending in ["wgsl", "glsl", "hlsl"] {
            let files = std::fs::read_dir(root.join(ending)).unwrap().map(|file| file.unwrap().path());
            let mut found: Vec<_> = files.map(|file| file.file_stem().unwrap().to_str().unwrap().to_owned()).collect();
            let mut listed: Vec<_> = KERNELS.iter().map(|kernel| kernel.name).collect();
            found.sort();
            listed.sort_unstable();
            assert_eq!(found, listed, "{ending}");
        }
        for kernel in KERNELS {
            for name in functions(kernel.text(Language::Wgsl)) {
                for language in [Language::Glsl, Language::Hlsl] {
                    let defined = format!(" {name}(");
                    let lines = kernel.text(language).lines();
                    let count = lines.filter(|line| line.contains(&defined) && line.ends_with('{')).count();
                    assert!(count >= 1, "{} {language:?}: {name}", kernel.name);
                }
            }
        }
    }

    #[test]
    fn unknown_names_are_told() {
        assert!(by_name("ndf").is_ok());
        let error = by_name("nfd").unwrap_err().to_string();
        assert!(error.contains("'nfd'") && error.contains("roughness, "), "{error}");
    }
}
