//! What the checks look at: a loaded material, and its pictures as their files hold them.

use std::borrow::Cow;
use std::path::Path;

use rayon::prelude::*;

use crate::error::Result;
use crate::image::{Raster, Size};
use crate::material::{Findings, Inputs, Material, NormalY, NormalZ, Origin, ReadPicture, Role, colour};

/// One picture of the set.
pub struct Picture<'a> {
    /// The file's name without its folder.
    pub file: String,
    /// The texels as the file holds them: not enlarged, no factor multiplied in.
    pub raster: Cow<'a, Raster>,
    /// `PNG`, `JPEG`, ...
    pub format: &'static str,
    /// What the file says about itself and was not obeyed.
    pub notes: Vec<String>,
    /// What each channel is read as.
    pub roles: &'a [Role],
    /// Whether normals are stored as -1..1.
    pub signed: bool,
}

/// A material under audit.
pub struct Subject<'a> {
    /// What it was loaded from.
    pub inputs: &'a Inputs,
    /// As a fold sees it.
    pub material: &'a Material,
    /// The maps that came from files, without those made from others.
    pub pictures: Vec<Picture<'a>>,
    /// A height map, whether or not the fold needs it.
    pub height: Option<Picture<'a>>,
    /// What loading counts. The means are those of all rows: loading takes some rows only, and a weave may agree with them.
    pub found: Findings,
}

/// Rows of one piece of work: enough to pay for its buffers.
const BAND: usize = 16;

/// Calls `f` with bands of rows side by side; results come in the order of the rows, so that sums do not depend on the
/// number of threads.
pub fn bands<T: Send>(rows: usize, f: impl Fn(std::ops::Range<usize>) -> T + Sync) -> Vec<T> {
    let count = rows.div_ceil(BAND);
    (0..count).into_par_iter().map(|i| f(i * BAND..((i + 1) * BAND).min(rows))).collect()
}

/// Vectors of a normal map as the file holds them, x, y and z in -1..1, y along the stored green.
pub struct Normals<'a> {
    /// The map.
    pub picture: &'a Picture<'a>,
    channels: [Option<usize>; 3],
    /// Whether z is stored, and not rebuilt from x and y.
    pub stored_z: bool,
    /// How green was read.
    pub y: NormalY,
}

/// One channel read as roughness or gloss.
pub struct Width<'a> {
    /// The map.
    pub picture: &'a Picture<'a>,
    /// Index of the channel.
    pub channel: usize,
    /// Whether it is gloss.
    pub smooth: bool,
}

impl Width<'_> {
    /// The channel in words, where the picture has several.
    pub fn channel_name(&self) -> Option<&'static str> {
        (self.picture.raster.channels.len() > 1).then(|| colour(self.channel))
    }
}

impl<'a> Subject<'a> {
    /// The pictures of a material. Those that loading changed are read again.
    pub fn new(inputs: &'a Inputs, material: &'a Material, read: ReadPicture, seen: &[Seen]) -> Result<Self> {
        let notes = |path: &Path| seen.iter().find(|s| s.path == path).map(|s| s.notes.clone()).unwrap_or_default();
        let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let mut pictures = Vec::new();
        for map in &material.maps {
            let Origin::File { path, size, format, derived: false, scaled, .. } = &map.origin else { continue };
            let changed = *scaled || *size != map.raster.size();
            pictures.push(Picture {
                file: name(path),
                raster: if changed { Cow::Owned(read(path)?.raster) } else { Cow::Borrowed(&map.raster) },
                format,
                notes: notes(path),
                roles: &map.roles,
                signed: map.signed,
            });
        }
        let height = match &inputs.height {
            Some(path) => match read(path) {
                Ok(decoded) => {
                    let (file, raster, format) = (name(path), Cow::Owned(decoded.raster), decoded.format);
                    Some(Picture { file, raster, format, notes: decoded.notes, roles: &[], signed: false })
                }
                // Beside a normal map nothing else needs it.
                Err(_) if inputs.normal.is_some() => None,
                Err(error) => return Err(error),
            },
            None => None,
        };
        let mut subject = Self { inputs, material, pictures, height, found: material.inspect() };
        if let Some(normals) = subject.normals() {
            let (mean_xy, mean_length) = normals.means();
            subject.found = Findings { mean_xy, mean_length, ..subject.found };
        }
        Ok(subject)
    }

    /// The normal map, if one was given: not normals from heights.
    pub fn normals(&self) -> Option<Normals<'_>> {
        let picture = self.pictures.iter().find(|picture| picture.roles.contains(&Role::NormalX))?;
        let channel = |role| picture.roles.iter().position(|r| *r == role);
        let stored_z = self.material.normal_z() == NormalZ::Stored;
        let z = channel(Role::NormalZ).filter(|_| stored_z);
        let channels = [channel(Role::NormalX), channel(Role::NormalY), z];
        Some(Normals { picture, channels, stored_z, y: self.material.normal_y })
    }

    /// The channel of the base width, if a map gives it.
    pub fn width(&self) -> Option<Width<'_>> {
        self.pictures.iter().find_map(|picture| {
            let is_width = |role: &Role| matches!(role, Role::Roughness | Role::Smoothness);
            // Gray stored as colour has the role three times; the green one is read, as all are alike.
            let mut channels = (0..picture.roles.len()).filter(|channel| is_width(&picture.roles[*channel]));
            let first = channels.next()?;
            let channel = channels.next().unwrap_or(first);
            Some(Width { picture, channel, smooth: picture.roles[channel] == Role::Smoothness })
        })
    }
}

/// A file that loading read.
pub struct Seen {
    /// As asked for.
    pub path: std::path::PathBuf,
    /// What the file says about itself and was not obeyed.
    pub notes: Vec<String>,
}

impl Normals<'_> {
    /// Size of the map.
    pub fn size(&self) -> Size {
        self.picture.raster.size()
    }

    /// One row of vectors; z is rebuilt where it is not stored.
    pub fn row(&self, y: usize, [nx, ny, nz]: [&mut [f32]; 3]) {
        let (scale, offset) = if self.picture.signed { (1.0, 0.0) } else { (2.0, -1.0) };
        for (channel, row) in self.channels.into_iter().zip([&mut *nx, &mut *ny, &mut *nz]) {
            if let Some(channel) = channel {
                self.picture.raster.read(channel, y, 0, row);
                row.iter_mut().for_each(|v| *v = scale * *v + offset);
            }
        }
        if self.channels[2].is_none() {
            for i in 0..nz.len() {
                nz[i] = (1.0 - nx[i] * nx[i] - ny[i] * ny[i]).max(0.0).sqrt();
            }
        }
    }

    /// Mean x and y, and mean length, of those that have a length.
    fn means(&self) -> ([f64; 2], f64) {
        let size = self.size();
        let parts = bands(size.height, |rows| {
            let (mut sums, mut row) = ([0.0f64; 4], [(); 3].map(|()| vec![0.0f32; size.width]));
            for y in rows {
                let [nx, ny, nz] = &mut row;
                self.row(y, [nx, ny, nz]);
                for ((x, y), z) in nx.iter().zip(&*ny).zip(&*nz) {
                    let length = (x * x + y * y + z * z).sqrt();
                    if length.is_finite() {
                        let terms = [1.0, f64::from(*x), f64::from(*y), f64::from(length)];
                        sums = std::array::from_fn(|i| sums[i] + terms[i]);
                    }
                }
            }
            sums
        });
        let [n, x, y, length] =
            parts.iter().fold([0.0; 4], |all: [f64; 4], part| std::array::from_fn(|i| all[i] + part[i]));
        let n = n.max(1.0);
        ([x / n, y / n], length / n)
    }

    /// Slopes of one row along +u and along green as it was read (`NormalY`), v up; NaN where the normal cannot be used.
    pub fn slopes(&self, y: usize, p: &mut [f32], q: &mut [f32], z: &mut [f32]) {
        self.row(y, [&mut *p, &mut *q, &mut *z]);
        let sign = self.y.sign();
        for i in 0..p.len() {
            // Flatter than 85 degrees: steeper ones are mostly rounding.
            let usable = z[i] > STEEPEST_Z * (p[i] * p[i] + q[i] * q[i] + z[i] * z[i]).sqrt();
            let scale = if usable { -1.0 / z[i] } else { f32::NAN };
            p[i] *= scale;
            q[i] *= sign * scale;
        }
    }
}

/// Least z of a normal whose slope is used: at 8 bits, a step of x is a fifth of the slope there.
pub const STEEPEST_Z: f32 = 0.0871;
