//! Extra maps: what is in their files, and what the energy and the diffuse scale are worth on real textures.
#![allow(clippy::print_stdout)]

mod common;

use std::path::{Path, PathBuf};

use common::desk::Desk;
use common::{bump, channel, entry, levels, manifest, names, plane, png_levels, png16, shrink};
use glam::Vec3;
use mipfold::compare::{Candidate, Settings, judge};
use mipfold::fold::{Chain, Options, chain};
use mipfold::image::Size;
use mipfold::material::{Inputs, Material, RoughnessInput, base_lobes, load, read_lobes};
use mipfold::moments::{Moments, diffuse};
use mipfold::ndf::{Axes, Burley, Form, Lobes, RoughnessTensor, TensorRoot};
use mipfold::reference::average_albedo;
use mipfold::roughness::{Alpha, PerceptualRoughness};
use rayon::prelude::*;

fn apart(a: RoughnessTensor, b: RoughnessTensor) -> f32 {
    (a.xx - b.xx).abs().max((a.xy - b.xy).abs()).max((a.yy - b.yy).abs())
}

/// The tensors of a level as each of the three maps has them, from channels in their order.
fn decoded(role: &str, float: bool, values: [f32; 3]) -> RoughnessTensor {
    let [r, g, b] = values;
    let turn = std::f32::consts::TAU;
    match role {
        "axes" if float => RoughnessTensor::from_axes(Axes { alpha_x: Alpha(r), alpha_y: Alpha(g), angle: b }),
        "axes" => {
            let [alpha_x, alpha_y] = [r, g].map(|v| PerceptualRoughness(v).alpha());
            RoughnessTensor::from_axes(Axes { alpha_x, alpha_y, angle: turn * b })
        }
        "burley" => Burley { alpha: PerceptualRoughness(r).alpha(), anisotropy: g, rotation: b }.tensor(),
        _ if float => TensorRoot { xx: r, xy: b, yy: g }.tensor(),
        _ => TensorRoot::decoded([r, g, b]).tensor(),
    }
}

/// The same by the shader helpers' twins.
fn by_shader(role: &str, float: bool, values: [f32; 3]) -> RoughnessTensor {
    use mipfold::kernels::twins::moments as shader;
    let texel = glam::DVec3::from_array(values.map(f64::from));
    let tensor = match role {
        "axes" if float => shader::decode_axes_signed(texel.x, texel.y, texel.z),
        "axes" => shader::decode_axes(texel),
        // As numbers in both containers.
        "burley" => shader::decode_burley(texel),
        _ if float => shader::decode_tensor_root_signed(texel),
        _ => shader::decode_tensor_root(texel),
    };
    let [xx, xy, yy] = tensor.as_vec3().to_array();
    RoughnessTensor { xx, xy, yy }
}

/// Every map of a real texture, in both containers, says what the lobes file says.
#[test]
fn extra_maps_of_a_real_texture_hold_its_lobes() {
    let Some(textures) = common::textures() else { return };
    let desk = Desk::empty();
    let folder = textures.join("bark014");
    let input = |name: &str| folder.join(name).display().to_string();
    let args = format!(
        "--normal {} --roughness {} --name bark --lobes aniso --format png,exr --float --extra axes,burley \
         --extra tensor,energy,diffuse",
        input("normal.jpg"),
        input("roughness.jpg")
    );
    let out = desk.build("out", &args);
    let lobes = read_lobes(&out.join("bark_lobes.exr")).unwrap().levels;
    let manifest = manifest(&out);
    for role in ["axes", "burley", "tensor"] {
        for container in ["png", "exr"] {
            let entry = entry(&manifest, role, container);
            assert_eq!(entry["channels"].as_array().unwrap().len(), 3);
            assert!(entry["decode"].as_str().is_some_and(|text| text.contains("S*S") || text.contains("alpha_x")));
            let names: Vec<_> = (0..3).map(|c| entry["channels"][c]["name"].as_str().unwrap()).collect();
            let float = container == "exr";
            let levels = levels(&out, &entry["files"]);
            assert_eq!(levels.len(), lobes.len());
            // Burley's reach ends at widths of 1 to 10, 8 bits round.
            let bound = if float { 1e-5 } else { 0.012 };
            for (raster, lobes) in levels.iter().zip(&lobes) {
                let planes: Vec<_> = names.iter().map(|name| channel(raster, name)).collect();
                let Size { width, .. } = lobes.size();
                for i in 0..planes[0].len() {
                    let expected = lobes.at(i % width, i / width).roughness;
                    let axes = expected.axes();
                    if role == "burley" && axes.alpha_y.0 < 0.1 * axes.alpha_x.0 {
                        continue;
                    }
                    let values = [planes[0][i], planes[1][i], planes[2][i]];
                    for got in [decoded(role, float, values), by_shader(role, float, values)] {
                        assert!(apart(got, expected) < bound, "{role} {container}: {got:?} for {expected:?}");
                    }
                }
            }
        }
    }
    for (role, unit) in [("energy", 2.5), ("diffuse", 1.0)] {
        let [png, exr] = ["png", "exr"].map(|container| levels(&out, &entry(&manifest, role, container)["files"]));
        assert!(plane(&png[0], 0).iter().all(|v| (unit * v - 1.0).abs() < 1e-6), "{role}: 1 at level 0");
        for (png, exr) in png.iter().zip(&exr) {
            let pairs = plane(png, 0).into_iter().zip(channel(exr, role));
            assert!(pairs.into_iter().all(|(a, b)| (unit * a - b).abs() <= unit * 0.5 / 255.0 + 1e-6), "{role}");
        }
        // Bark is rough: widened lobes lose energy, and mean normals are short.
        let last = channel(exr.last().unwrap(), role)[0];
        println!("{role}: {last}");
        assert!(if role == "energy" { last > 1.01 } else { last < 0.99 }, "{role}: {last}");
    }
    // A folder with extra maps is still read as the chain that it holds; a rebuild without them takes them away.
    let (code, stderr) = desk.run("compare @out --texels 1 --directions 4 --levels 8 --no-plain");
    assert_eq!(code, Some(0), "{stderr}");
    let build = format!("--normal {} --roughness {} --name bark", input("normal.jpg"), input("roughness.jpg"));
    desk.build("out", &build);
    assert!(names(&out).iter().all(|name| !name.contains("axes") && !name.contains("energy")), "{:?}", names(&out));
}

#[test]
fn what_a_chain_lacks_is_refused() {
    let desk = Desk::new();
    for map in ["axes", "burley", "tensor"] {
        let message = desk.refuses(&format!("--normal @n.png --extra {map} -o @out"), &format!("--extra {map}"));
        assert!(message.contains("--lobes aniso"), "{message}");
    }
    // A map of that name keeps it.
    std::fs::rename(desk.at("r.png"), desk.at("wall_energy.png")).unwrap();
    desk.warns("--normal @n.png --roughness @wall_energy.png --name wall --extra energy,energy -o @out", &[]);
    assert_eq!(png_levels(&desk.at("out"), "wall_energy").len(), 7);
    assert_eq!(png_levels(&desk.at("out"), "wall_energy_2").len(), 7);
    // Nobody's files are written over.
    desk.file("out/wall_diffuse_mip3.png", b"mine");
    desk.refuses("--normal @n.png --name wall --extra diffuse -o @out", "wall_diffuse_mip3.png");
}

/// Of odd sizes and 16 bits: both scales are what exact averages over footprints make them.
#[test]
fn scales_are_those_of_the_exact_footprints() {
    let desk = Desk::empty();
    let size = Size::new(21, 13);
    let wide = |v: f32| (v * 65535.0).round() as u16;
    let normal = |x, y| bump(x, y, 7).map(|v| wide(0.5 + 0.5 * v)).to_vec();
    png16(&desk.at("n.png"), (21, 13), normal);
    let rough = |x: usize, y: usize| 0.2 + 0.05 * ((3 * x + 5 * y) % 13) as f32;
    png16(&desk.at("r.png"), (21, 13), |x, y| vec![wide(rough(x, y))]);
    let args = "--normal @n.png --roughness @r.png --name odd --extra diffuse,energy --format png,exr --float";
    let out = desk.build("out", args);
    let manifest = manifest(&out);
    assert_eq!(entry(&manifest, "diffuse", "png")["encoding"], "unorm16");
    let each = |f: &dyn Fn(usize, usize) -> f32| -> Vec<f32> { (0..21 * 13).map(|i| f(i % 21, i / 21)).collect() };
    let parts: Vec<_> = (0..3).map(|c| each(&|x, y| bump(x, y, 7)[c])).collect();
    let albedo = each(&|x, y| average_albedo(PerceptualRoughness(rough(x, y)).alpha()) as f32);
    let lobes = read_lobes(&out.join("odd_lobes.exr")).unwrap().levels;
    let [lengths, energies] = ["diffuse", "energy"].map(|role| levels(&out, &entry(&manifest, role, "exr")["files"]));
    for k in 1..lobes.len() {
        let to = size.level(k);
        let means: Vec<_> = parts.iter().map(|part| shrink(part, size, to)).collect();
        let footprints = shrink(&albedo, size, to);
        let (length, energy) = (channel(&lengths[k], "diffuse"), channel(&energies[k], "energy"));
        for i in 0..to.texels() {
            let expected = means.iter().map(|mean| mean[i] * mean[i]).sum::<f64>().sqrt();
            assert!((f64::from(length[i]) - expected).abs() < 1e-4, "level {k}: {} {expected}", length[i]);
            let expected = footprints[i] / average_albedo(lobes[k].at(i % to.width, i / to.width).axes().alpha_x);
            assert!((f64::from(energy[i]) - expected).abs() < 1e-4, "level {k}: {} {expected}", energy[i]);
            assert!(length[i] < 0.999 && (energy[i] - 1.0).abs() > 1e-4);
        }
    }
}

/// A real map with alpha the same everywhere.
fn material(normal: &Path, alpha: f32) -> Material {
    let roughness = RoughnessInput::Constant(Alpha(alpha).perceptual());
    load(&Inputs { name: "real".into(), normal: Some(normal.into()), roughness, ..Inputs::default() }).unwrap()
}

/// Lights spread evenly over the hemisphere.
fn lights() -> Vec<Vec3> {
    let light = |i: usize| {
        let z = (i as f32 + 0.5) / 256.0;
        let (sin, cos) = (i as f32 * 2.399_963).sin_cos();
        let r = (1.0 - z * z).sqrt();
        Vec3::new(r * cos, r * sin, z)
    };
    (0..256).map(light).collect()
}

/// What a texel's diffuse term may be, from the moments of its footprint and a light.
type Model = (&'static str, fn(&Moments, Vec3) -> f32);

const MODELS: [Model; 7] = [
    ("renormalised", |m, l| m.normal().normalize().dot(l).max(0.0)),
    ("times the length", |m, l| diffuse::scaled(m.normal().normalize(), m.normal().length(), l)),
    ("length, softened", |m, l| diffuse::softened(m.normal().normalize(), m.normal().length(), l)),
    ("length, softened quickly", |m, l| diffuse::softened_quickly(m.normal().normalize(), m.normal().length(), l)),
    ("mean slope, unnormalised", |m, l| {
        let area = (1.0 + m.slope().length_squared() + m.slope_cov().xx + m.slope_cov().yy).sqrt();
        (l.z - m.slope().dot(l.truncate())).max(0.0) / area
    }),
    ("LEADR irradiance", |m, l| {
        let area = (1.0 + m.slope().length_squared() + m.slope_cov().xx + m.slope_cov().yy).sqrt();
        diffuse::leadr_irradiance(m.slope(), m.slope_cov(), l) / area
    }),
    ("LEADR diffuse", |m, l| diffuse::leadr_diffuse(m.slope(), m.slope_cov(), l)),
];

/// Errors of each model at levels `levels` of a map, over all lights and over those within 12 degrees of the
/// terminator: mean over texels of `sum |d - d_ref| / sum d_ref`; at most `most` texels a level.
fn diffuse_errors(base: &Lobes, levels: std::ops::RangeInclusive<usize>, most: usize) -> Vec<[f64; 2]> {
    let lights = lights();
    let size = base.size();
    let mut places = Vec::new();
    for k in levels {
        let to = size.level(k);
        let step = to.texels().div_ceil(most);
        // A step that is odd visits all columns.
        places.extend((0..to.texels()).step_by(step | 1).map(|i| (k, i % to.width, i / to.width)));
    }
    let errors: Vec<Vec<[f64; 2]>> = places
        .par_iter()
        .map(|&(k, x, y)| {
            let (mut moments, mut truth) = (Moments::default(), vec![0.0f64; lights.len()]);
            let n = 1usize << k;
            for j in 0..n * n {
                let normal = base.at(x * n + j % n, y * n + j / n).normal;
                moments += Moments::texel(1.0, normal, 0.5, RoughnessTensor::default());
                truth.iter_mut().zip(&lights).for_each(|(d, l)| *d += f64::from(normal.dot(*l).max(0.0)));
            }
            truth.iter_mut().for_each(|d| *d /= (n * n) as f64);
            let middle = moments.normal().normalize();
            let error = |(_, model): &Model| {
                let (mut error, mut sum) = ([0.0; 2], [0.0; 2]);
                for (l, d) in lights.iter().zip(&truth) {
                    let off = (f64::from(model(&moments, *l)) - d).abs();
                    let grazing = middle.dot(*l).abs() < 0.2;
                    error[0] += off;
                    sum[0] += d;
                    if grazing {
                        error[1] += off;
                        sum[1] += d;
                    }
                }
                [0, 1].map(|i| if sum[i] > 0.0 { error[i] / sum[i] } else { 0.0 })
            };
            MODELS.iter().map(error).collect()
        })
        .collect();
    (0..MODELS.len())
        .map(|m| [0, 1].map(|i| errors.iter().map(|e| e[m][i]).sum::<f64>() / errors.len() as f64))
        .collect()
}

/// The length pays, and the softening pays once more; the judge finds the same error for plain normals.
#[test]
fn the_diffuse_scale_pays_on_a_rough_map() {
    let Some(textures) = common::textures() else { return };
    let material = material(&textures.join("rock058/normal.jpg"), 0.3);
    let base = base_lobes(&material, Form::Isotropic);
    let errors = diffuse_errors(&base, 5..=5, usize::MAX);
    MODELS.iter().zip(&errors).for_each(|((name, _), e)| println!("{name}: {e:.4?}"));
    let [plain, scaled, soft] = [0, 1, 2].map(|i| errors[i][0]);
    assert!(scaled < 0.6 * plain && soft < 0.6 * scaled, "{plain} {scaled} {soft}");
    let levels = chain(&material, &Options::default()).into_lobes(base);
    let settings = Settings { texels: None, directions: 2, levels: vec![5], ..Settings::default() };
    let candidate = Candidate::new("plain normals", levels);
    let judged = judge(&material, &[candidate], &settings, &|_| ()).unwrap().chains[0].levels[0].diffuse_error.mean;
    assert!((judged / plain - 1.0).abs() < 0.05, "{judged} {plain}");
}

/// All real normal maps.
fn maps(textures: &Path) -> Vec<(String, PathBuf)> {
    let mut maps: Vec<_> = std::fs::read_dir(textures)
        .unwrap()
        .flat_map(|entry| {
            let folder = entry.unwrap().path();
            let name = folder.file_name().unwrap().to_string_lossy().into_owned();
            ["jpg", "png", "exr"].map(|ending| (name.clone(), folder.join("normal").with_extension(ending)))
        })
        .filter(|(_, path)| path.exists())
        .collect();
    maps.sort();
    assert!(maps.len() > 12, "{maps:?}");
    maps
}

/// `cargo test --test extras table_of_diffuse -- --ignored --nocapture`
#[test]
#[ignore = "a minute; its figures are in the README"]
fn table_of_diffuse_terms_on_all_real_normal_maps() {
    let Some(textures) = common::textures() else { return };
    let maps = maps(&textures);
    let mut sums = vec![[0.0; 2]; MODELS.len()];
    for (name, path) in &maps {
        let errors = diffuse_errors(&base_lobes(&material(path, 0.3), Form::Isotropic), 1..=6, 40);
        println!(
            "{name:<26} {}",
            errors.iter().map(|e| format!("{:.3}/{:.3}", e[0], e[1])).collect::<Vec<_>>().join("  ")
        );
        sums.iter_mut().zip(&errors).for_each(|(sum, e)| (0..2).for_each(|i| sum[i] += e[i] / maps.len() as f64));
    }
    for ((name, _), [all, grazing]) in MODELS.iter().zip(&sums) {
        println!("{name:<26} {all:.4} {grazing:.4}");
    }
    assert!(sums[1][0] < sums[0][0] && sums[2][0] < sums[1][0]);
}

/// Mean over texels of what the energy map holds, if every texel of the base has this width.
fn mean_scale(level: &Lobes, alpha: f32) -> f64 {
    let Size { width, height } = level.size();
    let base = average_albedo(Alpha(alpha));
    let own = |i: usize| average_albedo(level.at(i % width, i / width).axes().alpha_x);
    (0..width * height).map(|i| base / own(i)).sum::<f64>() / (width * height) as f64
}

/// `cargo test --test extras table_of_energy -- --ignored --nocapture`
#[test]
#[ignore = "minutes; its figures are in the README"]
fn table_of_energy_on_all_real_normal_maps() {
    let Some(textures) = common::textures() else { return };
    let maps = maps(&textures);
    let settings = Settings { texels: Some(16), directions: 40, levels: (1..=6).collect(), ..Settings::default() };
    for alpha in [0.05, 0.1, 0.2, 0.4] {
        let mut sums = [0.0; 6];
        for (name, path) in &maps {
            let material = material(path, alpha);
            let levels = folded(&material);
            let judgement = judge(&material, &[Candidate::new("folded", levels.clone())], &settings, &|_| ()).unwrap();
            let mut means = [0.0; 6];
            for score in &judgement.chains[0].levels {
                let (own, scale) = (score.energy.mean, mean_scale(&levels[score.level], alpha));
                let values = [own, own * scale, score.energy.compensated];
                for (i, v) in values.into_iter().enumerate() {
                    means[i] += (v - 1.0).abs() / 6.0;
                    means[3 + i] += (v - 1.0) / 6.0;
                }
            }
            println!("{alpha} {name:<26} {}", means.map(|v| format!("{v:+.3}")).join(" "));
            sums.iter_mut().zip(means).for_each(|(sum, v)| *sum += v / maps.len() as f64);
        }
        println!("{alpha} ALL                        {}", sums.map(|v| format!("{v:+.4}")).join(" "));
    }
}

fn folded(material: &Material) -> Vec<Lobes> {
    let folded: Chain = chain(material, &Options::default());
    folded.into_lobes(base_lobes(material, Form::Isotropic))
}

/// The scale does what multiple-scattering compensation does, for better and for worse: beside the truth without, a
/// folded lobe is near enough as it is, and on steep bumps, whose light is lost below the surface, the scale overshoots.
#[test]
fn the_energy_scale_does_what_compensation_does() {
    let Some(textures) = common::textures() else { return };
    let settings = Settings { texels: Some(16), directions: 40, levels: vec![4], ..Settings::default() };
    let measure = |name: &str| {
        let material = material(&textures.join(name), 0.1);
        let levels = folded(&material);
        let judgement = judge(&material, &[Candidate::new("folded", levels.clone())], &settings, &|_| ()).unwrap();
        let energy = judgement.chains[0].levels[0].energy.clone();
        let scaled = energy.mean * mean_scale(&levels[4], 0.1);
        println!("{name}: {:.3}, scaled {scaled:.3}, compensated {:.3}", energy.mean, energy.compensated);
        assert!((scaled / energy.compensated - 1.0).abs() < 0.05, "{name}: {scaled} {energy:?}");
        (energy.mean, scaled)
    };
    let (plain, scaled) = measure("bark014/normal.jpg");
    assert!((scaled - 1.0).abs() < (plain - 1.0).abs(), "gentle bumps: {plain} {scaled}");
    let (plain, scaled) = measure("fabric_knitted_006/normal.jpg");
    assert!((plain - 1.0).abs() < 0.5 * (scaled - 1.0), "steep bumps: {plain} {scaled}");
}
