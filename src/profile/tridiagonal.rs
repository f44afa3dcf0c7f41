//! The Newton system: block tridiagonal, with one 2 x 2 block per station, each coupled to the next.

use crate::number::Scalar;

/// One station's rows of the Newton system.
#[derive(Clone, Copy, Debug)]
pub struct BlockRow<S> {
    /// Diagonal block: bb, ba, aa.
    pub block: [S; 3],
    /// Right-hand side.
    pub gradient: [S; 2],
    /// Coupling of this station's (b, a) with the next one's, row by row.
    pub coupling: [S; 4],
    /// The step.
    pub step: [S; 2],
}

impl<S: Scalar> BlockRow<S> {
    pub const EMPTY: Self = Self {
        block: [S::ZERO; 3],
        gradient: [S::ZERO; 2],
        coupling: [S::ZERO; 4],
        step: [S::ZERO; 2],
    };
}

/// Rounding errors that a pivot keeps of its diagonal element at least: a system that rounding has made
/// singular gives a long step, which the line search shortens, and no infinite one.
const LEAST_PIVOT: f64 = 16.0;

/// Solves the system in place, by an L D L^T factorisation block by block (the Thomas algorithm of a positive definite
/// matrix): the gradient becomes the step. Returns gradient . step, the square of the Newton decrement.
///
/// Cost: about 60 multiplications and 12 divisions per station.
pub fn solve<S: Scalar>(rows: &mut [BlockRow<S>]) -> S {
    let tiny = S::EPSILON * S::of(LEAST_PIVOT);
    let mut left = &mut *rows;
    while let [here, later @ ..] = left {
        // L D L^T of the 2 x 2 block.
        let [bb, ba, aa] = here.block;
        let lower = ba / bb;
        let rest = (aa - ba * lower).greatest(aa * tiny);
        here.block = [bb, lower, rest];
        let Some(next) = later.first_mut() else { break };
        let [c0, c1, c2, c3] = here.coupling;
        // Columns of block^-1 coupling.
        let [x0, x2] = solve_block(here.block, [c0, c2]);
        let [x1, x3] = solve_block(here.block, [c1, c3]);
        let [y0, y1] = solve_block(here.block, here.gradient);
        let floor = [next.block[0] * tiny, next.block[2] * tiny];
        next.block[0] = (next.block[0] - (c0 * x0 + c2 * x2)).greatest(floor[0]);
        next.block[1] -= c0 * x1 + c2 * x3;
        next.block[2] = (next.block[2] - (c1 * x1 + c3 * x3)).greatest(floor[1]);
        next.gradient[0] -= c0 * y0 + c2 * y1;
        next.gradient[1] -= c1 * y0 + c3 * y1;
        left = later;
    }
    let mut decrement = S::ZERO;
    let mut after = [S::ZERO; 2];
    for here in rows.iter_mut().rev() {
        let BlockRow { block, gradient, coupling, .. } = *here;
        // Before it is overwritten: y^T D^-1 y sums to gradient . step.
        let u = gradient[0];
        let v = gradient[1] - block[1] * gradient[0];
        decrement += u * u / block[0] + v * v / block[2];
        let r0 = gradient[0] - (coupling[0] * after[0] + coupling[1] * after[1]);
        let r1 = gradient[1] - (coupling[2] * after[0] + coupling[3] * after[1]);
        here.gradient = solve_block(block, [r0, r1]);
        after = here.gradient;
    }
    decrement
}

/// Solves L D L^T x = r for a 2 x 2 block, given the first element of D, the one of L, and the second of D.
#[inline]
fn solve_block<S: Scalar>([d0, lower, d1]: [S; 3], [r0, r1]: [S; 2]) -> [S; 2] {
    let y = (r1 - lower * r0) / d1;
    [r0 / d0 - lower * y, y]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A diagonally dominant system of five stations: the residual of the solution, and the decrement.
    #[test]
    fn solution_leaves_no_residual() {
        let rows: [BlockRow<f64>; 5] = core::array::from_fn(|i| {
            let x = 1.0 + i as f64;
            BlockRow {
                block: [8.0 + x, 1.0 - 0.3 * x, 9.0],
                gradient: [x, 2.0 - x],
                coupling: if i < 4 { [0.5 * x, -1.0, 0.25, 1.5] } else { [0.0; 4] },
                step: [0.0; 2],
            }
        });
        let mut solved = rows;
        let decrement = solve(&mut solved);
        let mut sum = 0.0;
        for i in 0..5 {
            let x = |k: usize| solved.get(k).map_or([0.0; 2], |row| row.gradient);
            let [bb, ba, aa] = rows[i].block;
            let (here, next) = (x(i), x(i + 1));
            let c = rows[i].coupling;
            let mut left = [
                bb * here[0] + ba * here[1] + c[0] * next[0] + c[1] * next[1],
                ba * here[0] + aa * here[1] + c[2] * next[0] + c[3] * next[1],
            ];
            if i > 0 {
                let (c, before) = (rows[i - 1].coupling, x(i - 1));
                left[0] += c[0] * before[0] + c[2] * before[1];
                left[1] += c[1] * before[0] + c[3] * before[1];
            }
            for k in 0..2 {
                assert!((left[k] - rows[i].gradient[k]).abs() < 1e-12, "{i} {k}: {left:?}");
                sum += rows[i].gradient[k] * here[k];
            }
        }
        assert!((sum - decrement).abs() < 1e-12 * sum.abs(), "{sum} {decrement}");
    }

    /// Rounding can make a pivot vanish or worse: the step stays a number.
    #[test]
    fn a_singular_block_gives_a_finite_step() {
        let row = BlockRow {
            block: [1.0f32, 1.0, 1.0],
            gradient: [1.0, -1.0],
            coupling: [0.0; 4],
            step: [0.0; 2],
        };
        let mut rows = [row; 2];
        assert!(solve(&mut rows).is_finite());
        assert!(rows.iter().all(|row| row.gradient.iter().all(|x| x.is_finite())));
    }
}
