//! Chains that were built and read again, and files that are no chain.

mod mixtures;

use std::fs;
use std::path::{Path, PathBuf};

use ndarray::Array3;
use tempfile::TempDir;

use super::*;
use crate::codec::{Channel, Depth, write_exr, write_png};
use crate::fold::{self, Options};
use crate::image::{Raster, Samples, Wrap};
use crate::material::{MANIFEST, NormalY, NormalZ, load};
use crate::output::{Format, Plan, Request, write};
use crate::roughness::PerceptualRoughness;

fn png(path: &Path, (width, height): (usize, usize), texel: impl Fn(usize, usize) -> Vec<u8>) -> PathBuf {
    let channels = texel(0, 0).len();
    let samples = Array3::from_shape_fn((height, width, channels), |(y, x, c)| texel(x, y)[c]);
    write_png(fs::File::create(path).unwrap(), &Raster::new(Samples::U8(samples))).unwrap();
    path.to_owned()
}

/// Something bumpy, steep enough that a wrong sign, scale or channel shows.
fn bump(x: usize, y: usize) -> [f32; 3] {
    let (nx, ny) = (0.5 * (x as f32 * 0.9).sin() + 0.2, 0.4 * (y as f32 * 1.3 + x as f32).cos() - 0.15);
    [nx, ny, (1.0 - nx * nx - ny * ny).sqrt()]
}

fn normal_texel(x: usize, y: usize) -> Vec<u8> {
    bump(x, y).map(|v| ((0.5 + 0.5 * v) * 255.0).round() as u8).to_vec()
}

/// A material of odd size, its chain, and the folder with its files in every container.
struct Build {
    folder: TempDir,
    material: Material,
    levels: Vec<Lobes>,
}

const SIZE: (usize, usize) = (24, 10);

fn build(change: impl FnOnce(&mut Inputs), form: Form) -> Build {
    build_with(change, Options { form, slope_moments: true, ..Options::default() }, |_, _| ())
}

/// With a chain that `mix` changes, given each level's number.
fn build_with(change: impl FnOnce(&mut Inputs), options: Options, mix: impl Fn(usize, &mut Lobes)) -> Build {
    let form = options.form;
    let folder = tempfile::tempdir().unwrap();
    let mut inputs = Inputs {
        name: "wall".into(),
        normal: Some(png(&folder.path().join("n.png"), SIZE, normal_texel)),
        roughness: RoughnessInput::Roughness(ChannelRef {
            path: png(&folder.path().join("orm.png"), SIZE, |x, y| vec![9, (40 + 8 * x) as u8, (y * 20) as u8]),
            channel: Some(1),
        }),
        ..Inputs::default()
    };
    change(&mut inputs);
    let mut material = load(&inputs).unwrap();
    if form == Form::Anisotropic {
        material.ensure_anisotropy_map();
    }
    let mut chain = fold::chain(&material, &options);
    chain.levels.iter_mut().enumerate().for_each(|(i, level)| mix(i + 1, &mut level.lobes));
    let request = Request {
        formats: vec![Format::Png, Format::Exr],
        moments: options.slope_moments,
        ..Request::new(folder.path().join("out"))
    };
    let plan = Plan::new(&material, &options, &request);
    write(&material, &chain, &options, &plan, &request, &|| {}).unwrap();
    let levels = chain.into_lobes(base_lobes(&material, form));
    Build { folder, material, levels }
}

impl Build {
    fn out(&self) -> PathBuf {
        self.folder.path().join("out")
    }

    fn read(&self, container: Container) -> LevelChain {
        read_folder(&self.out(), Some(container)).unwrap()
    }
}

/// The largest differences of a normal's component and of a perceptual width over all texels of levels.
fn difference(a: &[Lobes], b: &[Lobes]) -> (f32, f32) {
    assert_eq!(a.len(), b.len());
    let (mut normal, mut width) = (0.0f32, 0.0f32);
    for (a, b) in a.iter().zip(b) {
        assert_eq!(a.size(), b.size());
        let Size { width: across, height } = a.size();
        for (x, y) in (0..height).flat_map(|y| (0..across).map(move |x| (x, y))) {
            let (p, q) = (a.at(x, y), b.at(x, y));
            normal = normal.max((p.normal - q.normal).abs().max_element());
            let (p, q) = (p.axes(), q.axes());
            for (p, q) in [(p.alpha_x, q.alpha_x), (p.alpha_y, q.alpha_y)] {
                width = width.max((p.perceptual().0 - q.perceptual().0).abs());
            }
        }
    }
    (normal, width)
}

#[test]
fn every_container_gives_the_folded_lobes_back() {
    let conventions: [&dyn Fn(&mut Inputs); 4] = [
        &|_| {},
        &|inputs| (inputs.normal_y, inputs.normal_scale) = (NormalY::DirectX, Some(0.7)),
        &|inputs| inputs.normal_z = NormalZ::Rebuild,
        &|inputs| {
            let RoughnessInput::Roughness(file) = inputs.roughness.clone() else { unreachable!() };
            inputs.roughness = RoughnessInput::Smoothness(file);
        },
    ];
    for (i, change) in conventions.iter().enumerate() {
        let build = build(change, Form::Isotropic);
        // Half a step of the file's depth, in a normal of -1..1 that is normalised again and may be scaled.
        let steps = [
            (Container::Png, 2.0 / 255.0, 0.51 / 255.0),
            (Container::Exr, 1.0 / 1024.0, 1.0 / 2048.0),
            (Container::Lobes, 1e-6, 1e-6),
        ];
        for (container, normal, width) in steps {
            let chain = build.read(container);
            assert_eq!(chain.levels.len(), 5);
            assert_eq!(chain.fold.as_deref(), Some("ggx"));
            let (n, w) = difference(&chain.levels, &build.levels);
            assert!(n < normal && w < width, "{i} {container:?}: normals {n}, widths {w}");
            if container != Container::Exr {
                assert_eq!(chain.levels[0], build.levels[0], "{i} {container:?}: level 0 is the input's own");
            }
        }
        let own = base_lobes(&build.read(Container::Lobes).level_0, Form::Isotropic);
        assert_eq!(own, base_lobes(&build.material, Form::Isotropic), "{i}");
    }
}

#[test]
fn two_widths_come_back_with_their_direction() {
    let build = build(|_| {}, Form::Anisotropic);
    for (container, width) in [(Container::Png, 0.02), (Container::Exr, 2e-3), (Container::Lobes, 1e-5)] {
        let chain = build.read(container);
        assert_eq!(chain.fold.as_deref(), Some("ggx, two widths"));
        assert_eq!(chain.levels[2].form(), Form::Anisotropic);
        let (_, w) = difference(&chain.levels, &build.levels);
        assert!(w < width, "{container:?}: widths {w}");
        let (read, wrote) = (chain.levels[3].at(1, 0), build.levels[3].at(1, 0));
        let mixed = (read.roughness.xy - wrote.roughness.xy).abs();
        assert!(wrote.roughness.xy.abs() > 1e-3 && mixed < 0.1 * wrote.roughness.xy.abs(), "{container:?}: {mixed}");
        assert!(!chain.level_0.is_anisotropic(), "{container:?}: the inputs had one width");
    }
}

#[test]
fn a_number_is_not_rounded_where_it_is_judged_against() {
    let build = build(|inputs| inputs.roughness = RoughnessInput::Constant(PerceptualRoughness(0.3)), Form::Isotropic);
    let chain = build.read(Container::Png);
    let perceptual = |lobes: &Lobes| lobes.at(3, 3).axes().alpha_x.perceptual().0;
    assert!((perceptual(&base_lobes(&chain.level_0, Form::Isotropic)) - 0.3).abs() < 1e-6);
    assert!((perceptual(&chain.levels[0]) - 77.0 / 255.0).abs() < 1e-6);
}

#[test]
fn a_lobes_file_alone_has_a_surface_of_its_own() {
    for form in [Form::Isotropic, Form::Anisotropic] {
        let build = build(|_| {}, form);
        let chain = read_lobes(&build.out().join("wall_lobes.exr")).unwrap();
        assert_eq!(chain.levels[1].form(), form);
        let (n, w) = difference(&[base_lobes(&chain.level_0, form)], &chain.levels[..1]);
        assert!(n < 1e-6 && w < 1e-6, "{n} {w}");
    }
}

#[test]
fn foreign_chains_are_read_by_pattern_and_from_mip_mapped_files() {
    let build = build(|inputs| inputs.normal_y = NormalY::DirectX, Form::Isotropic);
    let own = build.read(Container::Png);
    let file = |name: &str| build.out().join(name);
    let inputs = Inputs {
        name: "foreign".into(),
        normal: Some(file("n_mip%d.png")),
        roughness: RoughnessInput::Roughness(ChannelRef { path: file("orm_mip%d.png"), channel: Some(1) }),
        normal_y: NormalY::DirectX,
        ..Inputs::default()
    };
    assert_eq!(read_maps(&inputs).unwrap().levels, own.levels);
    let mipped = Inputs {
        normal: Some(file("n.exr")),
        roughness: RoughnessInput::Roughness(ChannelRef { path: file("orm.exr"), channel: Some(1) }),
        ..inputs.clone()
    };
    assert_eq!(read_maps(&mipped).unwrap().levels, build.read(Container::Exr).levels);
    let flat = Inputs { normal: None, ..inputs.clone() };
    let flat = read_maps(&flat).unwrap();
    assert!(flat.levels.iter().all(|level| level.at(0, 0).normal == glam::Vec3::Z));
    // Another convention is another chain.
    let turned = read_maps(&Inputs { normal_y: NormalY::OpenGl, ..inputs }).unwrap();
    assert!(difference(&turned.levels, &own.levels).0 > 0.1);
}

#[test]
fn level_0_settles_how_floats_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let channels = ["R", "G", "B"].map(|name| Channel { name: name.into(), depth: Depth::Float });
    let path = folder.path().join("n.exr");
    // Level 2, alone, would be more nearly unit if it were read as 0..1.
    write_exr(fs::File::create(&path).unwrap(), &channels, Size::new(4, 4), Wrap::Repeat, &|level, c, y, x, out| {
        for (i, out) in out.iter_mut().enumerate() {
            *out = if level == 2 { [0.5, 0.5, 1.0][c] } else { bump(x + i, y)[c] };
        }
    })
    .unwrap();
    let inputs = Inputs {
        normal: Some(path),
        roughness: RoughnessInput::Constant(PerceptualRoughness(0.5)),
        wrap: Wrap::Repeat,
        ..Inputs::default()
    };
    let chain = read_maps(&inputs).unwrap();
    let top = chain.levels[2].at(0, 0).normal;
    assert!((top - glam::Vec3::new(0.5, 0.5, 1.0).normalize()).length() < 1e-6, "{top}");
}

#[test]
fn patterns_are_told_from_names() {
    let at = |path: &str, k: usize| pattern(Path::new(path)).map(|file| file(k).display().to_string());
    assert_eq!(at("a/n_%d.png", 11).as_deref(), Some("a/n_11.png"));
    assert_eq!(at("n%02d.png", 3).as_deref(), Some("n03.png"));
    assert_eq!(at("%d/n.png", 0).as_deref(), Some("0/n.png"));
    assert_eq!(at("50%_%d.png", 1).as_deref(), Some("50%_1.png"));
    assert_eq!(at("50%d_%d.png", 1).as_deref(), Some("50%d_1.png"));
    assert_eq!(at("%d%%d.png", 7).as_deref(), Some("7%d.png"));
    assert_eq!(at("100%%_%02d.png", 1).as_deref(), Some("100%_01.png"));
    for name in ["n_%i.png", "n_%5d.png", "%%d.png", "n_%0000d.png", "n_%"] {
        assert!(at(name, 0).is_none(), "{name}");
    }
    for name in ["n.png", "50%.png", "n_%2d.png", "n_%x.png", "%", "wood%dark%.png0"] {
        let is = name == "wood%dark%.png0";
        assert_eq!(at(name, 0).is_some(), is, "{name}");
    }
}

/// The message of what must fail.
fn refused(result: Result<LevelChain>, wanted: &[&str]) {
    let message = result.map(|chain| chain.levels.len()).unwrap_err().to_string();
    assert!(wanted.iter().all(|part| message.contains(part)), "{message} lacks one of {wanted:?}");
}

#[test]
fn what_is_no_chain_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let chain = |normal: &str, roughness: RoughnessInput| {
        read_maps(&Inputs { name: "it".into(), normal: Some(at(normal)), roughness, ..Inputs::default() })
    };
    let half = || RoughnessInput::Constant(PerceptualRoughness(0.5));
    let map = |name: &str| RoughnessInput::Roughness(ChannelRef { path: at(name), channel: None });
    for k in 0..4 {
        png(&at(&format!("n_{k}.png")), (8 >> k, 8 >> k), normal_texel);
        png(&at(&format!("r_{k}.png")), (8 >> k, 8 >> k), |_, _| vec![99]);
    }
    assert_eq!(chain("n_%d.png", map("r_%d.png")).unwrap().levels.len(), 4);
    refused(chain("n_%d.png", RoughnessInput::Missing), &["without roughness"]);
    refused(chain("x_%d.png", half()), &["x_0.png"]);
    refused(chain("n_0.png", half()), &["n_0.png", "%d", "8x8"]);
    refused(chain("n_%i.png", half()), &["n_%i.png", "%d for the level"]);
    refused(chain("n_%d.png", map("r_0.png")), &["r_0.png", "%d"]);
    refused(chain("n_%d.png", map("gone.png")), &["gone.png"]);
    // One level too many, of a size that no level below 1x1 has.
    png(&at("n_4.png"), (1, 1), normal_texel);
    refused(chain("n_%d.png", half()), &["5 levels", "4 at most"]);
    refused(chain("n_%d.png", map("r_%d.png")), &["r_%d.png", "4 levels", "5 levels"]);
    fs::remove_file(at("n_4.png")).unwrap();
    png(&at("r_2.png"), (3, 2), |_, _| vec![99]);
    refused(chain("n_%d.png", map("r_%d.png")), &["r_2.png", "3x2", "2x2", "level 0 is 8x8"]);
    png(&at("r_0.png"), (4, 4), |_, _| vec![99]);
    refused(chain("n_%d.png", map("r_%d.png")), &["r_0.png", "4x4", "8x8"]);
    fs::remove_file(at("n_1.png")).unwrap();
    refused(chain("n_%d.png", half()), &["n_1.png", "level 3"]);
    fs::remove_file(at("n_0.png")).unwrap();
    refused(chain("n_%d.png", half()), &["n_0.png", "from 0 on"]);
}

#[test]
fn folders_that_no_build_wrote_or_that_have_changed_are_refused() {
    let build = build(|_| {}, Form::Isotropic);
    let out = build.out();
    let read = || read_folder(&out, None);
    let manifest = fs::read_to_string(out.join(MANIFEST)).unwrap();
    let edit = |from: &str, to: &str| {
        assert!(manifest.contains(from), "{from}");
        fs::write(out.join(MANIFEST), manifest.replace(from, to)).unwrap();
    };
    refused(read_folder(build.folder.path(), None), &["no manifest.json", "out"]);
    edit("\"schema\": 1", "\"schema\": 9");
    refused(read(), &["schema 9"]);
    edit("\"generator\": \"mipfold\"", "\"generator\": \"other\"");
    refused(read(), &["another program"]);
    edit("\"fold\"", "\"unfolded\"");
    refused(read(), &["damaged", "fold"]);
    edit("\"perceptual-roughness\"", "\"other\"");
    refused(read(), &["no roughness channel"]);
    edit("n_mip1.png", "../n_mip1.png");
    refused(read(), &["../n_mip1.png"]);
    edit("\"width\": 24", "\"width\": 25");
    refused(read(), &["24x10", "25x10"]);
    edit("\"container\": \"png\"", "\"container\": \"ktx\"");
    refused(read_folder(&out, Some(Container::Png)), &["exr, lobes"]);
    fs::write(out.join(MANIFEST), &manifest).unwrap();
    png(&out.join("n_mip1.png"), (13, 5), normal_texel);
    refused(read(), &["n_mip1.png", "13x5", "12x5"]);
    fs::remove_file(out.join("n_mip1.png")).unwrap();
    refused(read(), &["n_mip1.png is not there"]);
}

#[test]
fn lobes_files_that_hold_no_lobes_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let write = |names: [&str; 6], values: [f32; 6]| {
        let path = folder.path().join("x_lobes.exr");
        let channels = names.map(|name| Channel { name: name.into(), depth: Depth::Float });
        let file = fs::File::create(&path).unwrap();
        write_exr(file, &channels, Size::new(4, 2), Wrap::Repeat, &|_, c, _, _, out| out.fill(values[c])).unwrap();
        read_lobes(&path)
    };
    let good = [0.0, 0.0, 1.0, 0.5, 0.25, 0.0];
    assert_eq!(write(LOBE_CHANNELS, good).unwrap().levels.len(), 3);
    refused(write(["n.x", "n.y", "n.z", "alpha.x", "alpha", "angle"], good), &["x_lobes.exr", "alpha.y"]);
    for (channel, value) in [(0, f32::NAN), (2, -1.0), (2, 0.01), (3, 1.5), (4, -0.1), (5, f32::INFINITY)] {
        let mut wrong = good;
        wrong[channel] = value;
        refused(write(LOBE_CHANNELS, wrong), &["x_lobes.exr", "column 0, row 0 of level 0"]);
    }
    let picture = png(&folder.path().join("a.exr"), (2, 2), normal_texel);
    refused(read_lobes(&picture), &["a.exr", "PNG", "n.x"]);
}
