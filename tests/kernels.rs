//! `mipfold kernels`.

mod common;

use common::desk::Desk;
use common::{channel, entry, levels, manifest, mipfold, plane};
use glam::{DVec2, DVec3, DVec4};
use mipfold::image::Raster;
use mipfold::kernels::twins::moments as shader;
use mipfold::kernels::{KERNELS, Language, bundle, by_name};
use mipfold::material::read_lobes;

fn printed(args: &[&str]) -> String {
    let run = mipfold().arg("kernels").args(args).output().unwrap();
    assert!(run.status.success(), "{args:?}: {}", String::from_utf8_lossy(&run.stderr));
    String::from_utf8(run.stdout).unwrap()
}

#[test]
fn without_names_the_files_are_listed() {
    let list = printed(&[]);
    for kernel in KERNELS {
        assert!(list.lines().any(|line| line.trim_start().starts_with(kernel.name)), "{list}");
    }
    let json: serde_json::Value = serde_json::from_str(&printed(&["--json"])).unwrap();
    let names: Vec<_> = json["kernels"].as_array().unwrap().iter().map(|kernel| &kernel["name"]).collect();
    assert_eq!(names, KERNELS.iter().map(|kernel| kernel.name).collect::<Vec<_>>());
}

#[test]
fn files_are_printed_alone_or_with_all_that_they_need() {
    for (word, language) in [("wgsl", Language::Wgsl), ("glsl", Language::Glsl), ("hlsl", Language::Hlsl)] {
        for kernel in KERNELS {
            assert_eq!(printed(&[kernel.name, "--lang", word]).trim_end(), kernel.text(language).trim_end());
        }
        let footprint = by_name("footprint").unwrap();
        let whole = printed(&["footprint", "--lang", word, "--bundle"]);
        assert_eq!(whole.trim_end(), bundle(&[footprint], language).trim_end());
        for needed in footprint.needs() {
            assert_eq!(whole.matches(needed.text(language)).count(), 1, "{word}: {}", needed.name);
        }
    }
}

#[test]
fn an_unknown_file_is_told_with_all_that_there_are() {
    let run = mipfold().args(["kernels", "nfd"]).output().unwrap();
    assert_eq!(run.status.code(), Some(2));
    let said = String::from_utf8(run.stderr).unwrap();
    assert!(said.contains("'nfd'") && KERNELS.iter().all(|kernel| said.contains(kernel.name)), "{said}");
}

/// Red, green, blue and alpha of all texels, by name where there are names; 0 for what is not there.
fn texels(raster: &Raster) -> Vec<DVec4> {
    let index = |c: usize| match raster.channels.iter().position(|name| name == ["R", "G", "B", "A"][c]) {
        Some(index) => Some(index),
        None if raster.channels.iter().any(|name| name == "G") => None,
        None => (c < raster.channels.len()).then_some(c),
    };
    let planes = [0, 1, 2, 3].map(|c| index(c).map(|c| plane(raster, c)));
    let at = |i: usize| planes.each_ref().map(|plane| plane.as_ref().map_or(0.0, |plane| f64::from(plane[i])));
    let size = raster.size();
    (0..size.texels()).map(|i| DVec4::from_array(at(i))).collect()
}

/// A mixture's maps, in both containers and conventions, decoded as shaders do, are what the lobes file says.
#[test]
fn shaders_read_what_build_writes() {
    for (convention, y_sign) in [("opengl", 1.0), ("directx", -1.0)] {
        let desk = Desk::new();
        let maps = format!("--normal @n.png --normal-y {convention} --roughness @r.png --name wall");
        let out = desk.build("out", &format!("{maps} --lobes 2-aniso --format png,exr --float"));
        let lobes = read_lobes(&out.join("wall_lobes.exr")).unwrap().levels;
        let manifest = manifest(&out);
        for (container, bound) in [("png", 0.02), ("exr", 2e-5)] {
            let float = container == "exr";
            let roles = ["normal", "roughness", "anisotropy", "lobe", "lobe-anisotropy"];
            let maps = roles.map(|role| levels(&out, &entry(&manifest, role, container)["files"]));
            for (k, expected) in lobes.iter().enumerate() {
                let [normal, roughness, anisotropy, further, further_anisotropy] =
                    maps.each_ref().map(|map| texels(&map[k]));
                for i in 0..normal.len() {
                    let first = if float {
                        shader::decode_normal_signed(normal[i].truncate(), y_sign, 1.0)
                    } else {
                        shader::decode_normal(normal[i].truncate(), y_sign, 1.0)
                    };
                    let second = if float {
                        shader::decode_lobe_signed(further[i], y_sign, 1.0)
                    } else {
                        shader::decode_lobe(further[i], y_sign, 1.0)
                    };
                    let found = [
                        (first, shader::decode_anisotropy(anisotropy[i].truncate(), roughness[i].x)),
                        (second.normal, shader::decode_anisotropy(further_anisotropy[i].truncate(), further[i].w)),
                    ];
                    let weights = [shader::first_weight(DVec3::new(second.weight, 0.0, 0.0)), second.weight];
                    let width = expected.size().width;
                    for (j, (n, tensor)) in found.into_iter().enumerate() {
                        let (lobe, weight) = expected.slot(j, i % width, i / width);
                        let about = format!("{convention} {container} level {k} lobe {j}: {n} {tensor} for {lobe:?}");
                        assert!((n - lobe.normal.as_dvec3()).length() < bound, "{about}");
                        assert!((weights[j] - f64::from(weight)).abs() < bound, "{about}");
                        let r = lobe.roughness;
                        let apart = tensor - DVec3::new(r.xx.into(), r.xy.into(), r.yy.into());
                        assert!(apart.abs().max_element() < bound, "{about}");
                    }
                    // z rebuilt from x and y alone is the same normal, but for the rounding of level 0's own 8 bits.
                    let [x, y] = [normal[i].x, normal[i].y];
                    let rebuilt = if float {
                        shader::decode_normal_xy_signed(DVec2::new(x, y), y_sign, 1.0)
                    } else {
                        shader::decode_normal_xy(DVec2::new(x, y), y_sign, 1.0)
                    };
                    assert!((rebuilt - first).length() < 0.02, "{rebuilt} {first}");
                }
            }
        }
    }
}

/// Raw moments, decoded and read out as shaders do, are the lobes of the fold `lean`, in both conventions.
#[test]
fn shaders_read_slope_moments() {
    for (convention, y_sign) in [("opengl", 1.0), ("directx", -1.0)] {
        let desk = Desk::new();
        let maps = format!("--normal @n.png --normal-y {convention} --roughness 0.3 --name wall");
        let out = desk.build("out", &format!("{maps} --fold lean --lobes aniso --moments --format exr --float"));
        let lobes = read_lobes(&out.join("wall_lobes.exr")).unwrap().levels;
        let base = f64::from(lobes[0].at(0, 0).roughness.xx);
        let files = levels(&out, &entry(&manifest(&out), "slope-moments", "exr")["files"]);
        for (k, (raster, lobes)) in files.iter().zip(&lobes).enumerate() {
            let names = ["b1_dhds", "b2_dhdt", "b3_dhds2", "b4_dhdt2", "b5_dh2dsdt"];
            let planes = names.map(|name| channel(raster, name));
            let width = lobes.size().width;
            for i in 0..lobes.size().texels() {
                let [x, y, xx, yy, xy] = planes.each_ref().map(|plane| f64::from(plane[i]));
                let moments = shader::decode_moments(DVec2::new(x, y), DVec3::new(xx, yy, xy), y_sign);
                let found = shader::lobe_from_moments(moments, DVec3::new(base, 0.0, base));
                let expected = lobes.at(i % width, i / width);
                let r = expected.roughness;
                let apart = found.tensor - DVec3::new(r.xx.into(), r.xy.into(), r.yy.into());
                let about = format!("{convention} level {k}: {found:?} for {expected:?}");
                assert!((found.normal - expected.normal.as_dvec3()).length() < 2e-4, "{about}");
                assert!(apart.abs().max_element() < 1e-4, "{about}");
            }
        }
    }
}

/// A haze map: two lobes that share a normal, in both containers.
#[test]
fn shaders_read_haze() {
    let desk = Desk::new();
    let maps = "--normal @n.png --roughness @r.png --name wall";
    let out = desk.build("out", &format!("{maps} --lobes haze --format png,exr --float"));
    let lobes = read_lobes(&out.join("wall_lobes.exr")).unwrap().levels;
    let manifest = manifest(&out);
    let mut hazy = 0;
    for (container, bound) in [("png", 0.005), ("exr", 1e-5)] {
        let files = levels(&out, &entry(&manifest, "haze", container)["files"]);
        for (k, (raster, lobes)) in files.iter().zip(&lobes).enumerate() {
            let width = lobes.size().width;
            for (i, texel) in texels(raster).into_iter().enumerate() {
                let (x, y) = (i % width, i / width);
                let (second, weight) = lobes.slot(1, x, y);
                let normal = lobes.at(x, y).normal.as_dvec3();
                let found = shader::decode_haze(DVec2::new(texel.x, texel.y), normal);
                let about = format!("{container} level {k}: {found:?} for {second:?} of {weight}");
                assert!((found.normal - second.normal.as_dvec3()).length() < 1e-6, "{about}");
                assert!((found.weight - f64::from(weight)).abs() < bound, "{about}");
                assert!(
                    (found.tensor.x.powf(0.25) - f64::from(second.roughness.xx).powf(0.25)).abs() < bound,
                    "{about}"
                );
                hazy += usize::from(weight > 0.1);
            }
        }
    }
    assert!(hazy > 100, "{hazy}");
}
