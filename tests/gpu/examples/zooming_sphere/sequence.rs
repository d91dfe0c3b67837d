//! The frames: a sphere that turns slowly at each of some distances.

use std::error::Error;

use crate::measure::{Figures, figures, whole_pixels};
use crate::renderer::{Curvature, Picture, Renderer, Textures, Way};
use crate::scene::Pose;
use crate::show::{Frame, PANE};

/// By how much the sphere is smaller than where it is nearest. The panes are enlarged by these, so they divide [`PANE`].
pub const SHRUNK: &[u32] = &[1, 2, 3, 4, 6, 8, 12, 16];

/// Of the panes, from left to right.
pub const CAPTIONS: [&str; 4] = ["plain mips", "folded", "and curvature", "truth"];

/// Above the rows.
pub const HEADING: &str = concat!(
    "               error                       brightness                  flicker\n",
    "size pixels    plain   folded  curvature   plain   folded  curvature   plain   folded  curvature   truth moves\n",
);

/// Below the rows.
pub const FOOTNOTE: &str = "
error: root mean square of pane - truth, linear radiance. brightness: mean over that of the truth. flicker: mean change
from frame to frame that the truth does not show, or lacks; beside it the truth's own change. Error and changes are shares of
the truth's mean radiance. Pixels that the sphere covers wholly count. folded: without curvature; curvature: folded, with it.
";

/// What to draw at each distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sequence {
    /// Frames a distance.
    pub frames: usize,
    /// Degrees from frame to frame.
    pub turn: f32,
    /// Of the truth, along a side of a pixel where the sphere is nearest.
    pub rays: u32,
    /// Of the third pane.
    pub curvature: Curvature,
}

impl Default for Sequence {
    fn default() -> Self {
        Self { frames: 10, turn: 1.5, rays: 16, curvature: Curvature::Normals }
    }
}

/// Frames of one distance.
pub struct Drawn {
    shrunk: u32,
    /// Plain, folded, folded with curvature, truth.
    panes: [Vec<Picture>; 4],
}

impl Sequence {
    /// The frames of a distance: the sphere turns on from where it was at the distance before.
    pub fn at(
        &self,
        renderer: &Renderer,
        plain: &Textures,
        folded: &Textures,
        shrunk: u32,
    ) -> Result<Drawn, Box<dyn Error>> {
        let side = PANE as u32 / shrunk;
        let before = SHRUNK.iter().position(|&s| s == shrunk).unwrap_or(0) * self.frames;
        let mut panes: [Vec<Picture>; 4] = Default::default();
        for frame in 0..self.frames {
            let turn = ((before + frame) as f32 * self.turn).to_radians();
            let pose = Pose { shrunk: shrunk as f32, turn };
            let ways = [
                (plain, Way::Mips(Curvature::None)),
                (folded, Way::Mips(Curvature::None)),
                (folded, Way::Mips(self.curvature)),
                (folded, Way::Rays(self.rays * shrunk)),
            ];
            for (pane, (textures, way)) in panes.iter_mut().zip(ways) {
                pane.push(renderer.draw(textures, pose, side, way)?);
            }
        }
        Ok(Drawn { shrunk, panes })
    }
}

impl Drawn {
    /// Of plain mips, folded ones, folded ones with curvature, and of the truth itself.
    pub fn figures(&self) -> [Figures; 4] {
        let [.., truth] = &self.panes;
        self.panes.each_ref().map(|pane| figures(pane, truth))
    }

    /// In terms of the nearest one.
    fn size(&self) -> String {
        if self.shrunk == 1 { "1".to_string() } else { format!("1/{}", self.shrunk) }
    }

    /// A line of the table.
    pub fn row(&self) -> String {
        let [plain, folded, curved, truth] = self.figures();
        let three =
            |pick: fn(&Figures) -> f64| format!("{:<8.3}{:<8.3}{:<12.3}", pick(&plain), pick(&folded), pick(&curved));
        let size = self.size();
        let (error, brightness, flicker) = (three(|f| f.error), three(|f| f.brightness), three(|f| f.flicker));
        format!("{size:<5}{:<10}{error}{brightness}{flicker}{:.3}\n", PANE as u32 / self.shrunk, truth.change)
    }

    /// By which radiances are multiplied to be shown: the truth's mean becomes a middle gray.
    pub fn exposure(&self) -> f32 {
        let truth = &self.panes[3];
        let whole = whole_pixels(truth);
        let sum: f32 = whole.iter().map(|&i| truth[0].pixels[i][..3].iter().sum::<f32>()).sum();
        0.2 * 3.0 * whole.len() as f32 / sum.max(f32::MIN_POSITIVE)
    }

    /// Panes side by side, frame by frame.
    pub fn frames(&self, exposure: f32) -> Vec<Frame> {
        let below = format!("{} - {} pixels", self.size(), PANE as u32 / self.shrunk);
        let frame = |i: usize| {
            let panes: Vec<_> = CAPTIONS.iter().copied().zip(self.panes.iter().map(|pane| &pane[i])).collect();
            Frame::new(&panes, &below, exposure)
        };
        (0..self.panes[0].len()).map(frame).collect()
    }
}
