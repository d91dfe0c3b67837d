//! How a query goes about it, and what it took.

/// What becomes of the tails of the material's lobe, which for GGX fall as the fourth power only.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Tails {
    /// They are kept, coarsely sampled where they are below 1e-4 of the peak: energy is whole.
    #[default]
    Kept,
    /// Texels all of whose normals are further from h than this many alphas (as tangents) do not count, and are not
    /// visited where the pyramid tells. Much quicker on rough maps; up to `1 / (1 + x^2)` of the energy is lost.
    Cut(f64),
}

/// What a query visited.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Visits {
    /// Blocks of the pyramid whose ranges were looked at.
    pub nodes: usize,
    /// Cells whose texels were read.
    pub texels: usize,
    /// Pieces of cells integrated in closed form, four triangles each.
    pub closed: usize,
    /// Pieces of cells, and blocks, evaluated at four points.
    pub points: usize,
}

impl std::ops::AddAssign for Visits {
    fn add_assign(&mut self, other: Self) {
        self.nodes += other.nodes;
        self.texels += other.texels;
        self.closed += other.closed;
        self.points += other.points;
    }
}

/// Limits of the ways to integrate. Tests compare others with [`Ways::BEST`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Ways {
    /// Blocks out of reach are not entered.
    pub(super) prune: bool,
    /// Blocks that their moments stand for are not entered.
    pub(super) moments: bool,
    /// Pieces narrower in position than in slope are integrated in closed form, not divided until points do.
    pub(super) closed: bool,
    /// Longest side of a piece, over the shorter radius of the kernel, on which the kernel is taken as linear.
    pub(super) kernel_linear: f64,
    /// The same where it is taken at Gauss nodes.
    pub(super) kernel_nodes: f64,
    /// The same for a block that its moments stand for.
    pub(super) kernel_block: f64,
    /// Largest squared extent of a piece, in widths of the lobe at its distance, that Gauss nodes do for.
    pub(super) extent_nodes: f64,
    /// The same for the moments of a block.
    pub(super) extent_block: f64,
    /// `1 + d^2` for a distance of d widths from which the tail of the lobe need not be resolved,
    pub(super) far: f64,
    /// how much larger the squared extent of a piece may then be, over `1 + d^2`,
    pub(super) extent_nodes_far: f64,
    /// and that of a block.
    pub(super) extent_block_far: f64,
    /// Departure of a piece from its triangles, in widths of the lobe at its distance.
    pub(super) twist: f64,
    /// Ratio of the squared lengths of N within a piece up to which their powers are taken as linear.
    pub(super) steepening: f64,
    /// Ratio of the widths within a piece up to which it has one.
    pub(super) widening: f64,
}

impl Ways {
    /// Errors in balance.
    pub(super) const BEST: Self = Self {
        prune: true,
        moments: true,
        closed: true,
        kernel_linear: 0.25,
        kernel_nodes: 0.36,
        kernel_block: 0.25,
        extent_nodes: 0.36,
        extent_block: 0.1,
        far: 101.0,
        extent_nodes_far: 2.5,
        extent_block_far: 1.0,
        twist: 0.04,
        steepening: 1.1,
        widening: 1.1,
    };
}

/// Where normals lie, in widths of the lobe.
pub(super) struct Range {
    /// `1 + d^2` of the nearest.
    pub(super) near: f64,
    /// Squared diagonal of their box.
    pub(super) extent: f64,
}

impl Range {
    /// Of all convex combinations of the corners, which are in the frame of h.
    #[inline]
    pub(super) fn new(p: &[glam::DVec3; 4], inverse: f64) -> Self {
        let (min, max) = (p[0].min(p[1]).min(p[2].min(p[3])), p[0].max(p[1]).max(p[2].max(p[3])));
        let zero = glam::DVec2::ZERO;
        let apart = min.truncate().max(-max.truncate()).max(zero).length_squared();
        // The same box turned by an eighth, for what lies along a diagonal.
        let turned = p.map(|p| glam::DVec2::new(p.x + p.y, p.x - p.y));
        let least = turned[0].min(turned[1]).min(turned[2].min(turned[3]));
        let most = turned[0].max(turned[1]).max(turned[2].max(turned[3]));
        let apart = apart.max(0.5 * least.max(-most).max(zero).length_squared());
        let inverse2 = inverse * inverse;
        let near = if max.z > 0.0 { 1.0 + apart * inverse2 / (max.z * max.z) } else { f64::INFINITY };
        let z = min.z.max(0.05);
        Self { near, extent: (max - min).truncate().length_squared() * inverse2 / (z * z) }
    }

    /// Whether all normals are nearer than a cut, for certain.
    #[inline]
    pub(super) fn within(&self, cut: f64) -> bool {
        cut.is_infinite() || ((self.near - 1.0).sqrt() + self.extent.sqrt()).powi(2) < cut - 1.0
    }

    /// Whether points stand for these normals.
    #[inline]
    pub(super) fn few(&self, far: f64, extent: [f64; 2]) -> bool {
        self.extent <= self.near * if self.near > far { extent[1] } else { extent[0] }
    }
}
