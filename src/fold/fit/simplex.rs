//! Search without derivatives.
//!
//! Based on: J. A. Nelder, R. Mead, "A Simplex Method for Function Minimization", 1965; F. Gao, L. Han, "Implementing the
//! Nelder-Mead simplex algorithm with adaptive parameters", 2012, for the order of the tests.

/// When a search ends.
#[derive(Clone, Copy)]
pub struct Stop {
    /// Once the values at all corners differ by no more than this.
    pub spread: f32,
    /// After so many steps.
    pub steps: usize,
}

/// A minimum of `f` near 0, and its value there; `at_zero` is `f` at 0, and `size` how far the first corners lie from it.
/// What is not a number counts as worse than any.
pub fn minimise<const N: usize>(
    at_zero: f32,
    size: f32,
    stop: Stop,
    mut f: impl FnMut(&[f32; N]) -> f32,
) -> ([f32; N], f32) {
    let mut value = |x: &[f32; N]| {
        let value = f(x);
        if value.is_nan() { f32::INFINITY } else { value }
    };
    let mut corners = Vec::with_capacity(N + 1);
    corners.push(([0.0; N], at_zero));
    for i in 0..N {
        let mut x = [0.0; N];
        x[i] = size;
        corners.push((x, value(&x)));
    }
    for _ in 0..stop.steps {
        // Stable, so that equal corners stay in order.
        corners.sort_by(|a, b| a.1.total_cmp(&b.1));
        let (best, second, (worst, highest)) = (corners[0], corners[N - 1].1, corners[N]);
        if highest - best.1 <= stop.spread {
            break;
        }
        let middle: [f32; N] = std::array::from_fn(|i| corners[..N].iter().map(|(x, _)| x[i]).sum::<f32>() / N as f32);
        let along = |t: f32| -> [f32; N] { std::array::from_fn(|i| middle[i] + t * (worst[i] - middle[i])) };
        let reflected = along(-1.0);
        let found = value(&reflected);
        let (next, good) = if found < best.1 {
            let further = along(-2.0);
            let expanded = value(&further);
            (if expanded < found { (further, expanded) } else { (reflected, found) }, true)
        } else if found < second {
            ((reflected, found), true)
        } else {
            let contracted = along(if found < highest { -0.5 } else { 0.5 });
            let value = value(&contracted);
            ((contracted, value), value < highest.min(found))
        };
        if good {
            corners[N] = next;
            continue;
        }
        for (x, corner) in &mut corners[1..] {
            *x = std::array::from_fn(|i| 0.5 * (x[i] + best.0[i]));
            *corner = value(x);
        }
    }
    corners.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).expect("a simplex has corners")
}

#[cfg(test)]
mod tests {
    use super::*;

    const STOP: Stop = Stop { spread: 1e-7, steps: 400 };

    #[test]
    fn bowls_and_valleys() {
        // Rosenbrock's valley, moved so that the search begins at his usual start.
        let valley = |x: &[f32; 2]| {
            let (x, y) = (x[0] - 1.2, x[1] + 1.0);
            (1.0 - x).powi(2) + 100.0 * (y - x * x).powi(2)
        };
        let (x, value) = minimise(valley(&[0.0; 2]), 0.5, STOP, valley);
        assert!(value < 1e-5 && (x[0] - 2.2).abs() < 0.01 && x[1].abs() < 0.02, "{x:?} {value}");
        let bowl = |x: &[f32; 5]| (0..5).map(|i| (i + 1) as f32 * (x[i] - 0.2 * i as f32).abs().powf(1.5)).sum::<f32>();
        let (x, value) = minimise(bowl(&[0.0; 5]), 0.2, STOP, bowl);
        assert!(value < 1e-4, "{x:?} {value}");
    }

    #[test]
    fn what_is_no_number_is_avoided() {
        let f = |x: &[f32; 3]| if x[0] > 0.1 { f32::NAN } else { (x[0] - 1.0).powi(2) + x[1].powi(2) + x[2].powi(2) };
        let (x, value) = minimise(1.0, 0.3, STOP, f);
        assert!(x[0] <= 0.1 && value < 0.85, "{x:?} {value}");
        let (x, value) = minimise(0.5, 0.3, STOP, |_: &[f32; 3]| f32::NAN);
        assert_eq!((x, value), ([0.0; 3], 0.5));
    }
}
