//! Footprints along one axis.

/// The texels of the source under one texel of the target along one axis.
///
/// A footprint is the product of a span in x and a span in y: for a box filter that is exact for every size.
#[derive(Clone, Debug, PartialEq)]
pub struct Span {
    /// First source texel that the footprint touches.
    pub first: usize,
    /// Length of each touched texel inside the footprint, in source texels: 1, or less at the two ends.
    pub weights: Vec<f32>,
}

/// The span of texel `i` of `target` over a row of `source` texels, `target <= source`: it covers
/// `[i, i + 1) * source / target`. Lengths are rational with denominator `target`, so each is rounded once.
pub fn span(source: usize, target: usize, i: usize) -> Span {
    assert!(target >= 1 && target <= source && i < target);
    // In units of 1/target of a source texel.
    let (start, end) = (i * source, (i + 1) * source);
    let first = start / target;
    let last = end.div_ceil(target);
    let weights = (first..last)
        .map(|j| {
            let overlap = end.min((j + 1) * target) - start.max(j * target);
            (overlap as f64 / target as f64) as f32
        })
        .collect();
    Span { first, weights }
}

/// The spans of all `target` texels.
pub fn spans(source: usize, target: usize) -> Vec<Span> {
    (0..target).map(|i| span(source, target, i)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn three_to_two_worked_by_hand() {
        let spans = spans(3, 2);
        assert_eq!(spans[0], Span { first: 0, weights: vec![1.0, 0.5] });
        assert_eq!(spans[1], Span { first: 1, weights: vec![0.5, 1.0] });
    }

    proptest! {
        #[test]
        fn every_source_texel_is_used_once(source in 1usize..300, share in 0.0f64..1.0) {
            let target = 1 + (share * (source - 1) as f64) as usize;
            let spans = spans(source, target);
            let mut used = vec![0.0f64; source];
            for span in &spans {
                let total: f64 = span.weights.iter().map(|&w| f64::from(w)).sum();
                prop_assert!((total - source as f64 / target as f64).abs() < 1e-5 * total);
                for (j, &w) in span.weights.iter().enumerate() {
                    prop_assert!(w > 0.0);
                    used[span.first + j] += f64::from(w);
                }
            }
            prop_assert!(used.iter().all(|u| (u - 1.0).abs() < 1e-6));
        }
    }
}
