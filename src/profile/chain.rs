//! The Newton system: a chain of 2 x 2 blocks, each coupled to the next.

use crate::number::Scalar;

/// One station's part of the Newton system.
#[derive(Clone, Copy, Debug)]
pub struct Work<S> {
    /// Diagonal block: bb, ba, aa.
    pub block: [S; 3],
    /// Right-hand side.
    pub gradient: [S; 2],
    /// Coupling of this station's (b, a) with the next one's, row by row.
    pub coupling: [S; 4],
    /// The step.
    pub step: [S; 2],
}

impl<S: Scalar> Work<S> {
    pub const EMPTY: Self = Self {
        block: [S::ZERO; 3],
        gradient: [S::ZERO; 2],
        coupling: [S::ZERO; 4],
        step: [S::ZERO; 2],
    };
}

/// Solves the chain in place: the gradient becomes the step. Returns gradient . step.
pub fn solve<S: Scalar>(work: &mut [Work<S>]) -> S {
    let tiny = S::EPSILON * S::of(16.0);
    let mut left = &mut *work;
    while let [here, later @ ..] = left {
        // L D L^T of the 2 x 2 block.
        let [bb, ba, aa] = here.block;
        let lower = ba / bb;
        let rest = (aa - ba * lower).greatest(aa * tiny);
        here.block = [bb, lower, rest];
        let Some(next) = later.first_mut() else { break };
        let [c0, c1, c2, c3] = here.coupling;
        // Columns of block^-1 coupling.
        let (x0, x2) = solve_block(bb, lower, rest, c0, c2);
        let (x1, x3) = solve_block(bb, lower, rest, c1, c3);
        let [g0, g1] = here.gradient;
        let (y0, y1) = solve_block(bb, lower, rest, g0, g1);
        let floor = [next.block[0] * tiny, next.block[2] * tiny];
        next.block[0] = (next.block[0] - (c0 * x0 + c2 * x2)).greatest(floor[0]);
        next.block[1] -= c0 * x1 + c2 * x3;
        next.block[2] = (next.block[2] - (c1 * x1 + c3 * x3)).greatest(floor[1]);
        next.gradient[0] -= c0 * y0 + c2 * y1;
        next.gradient[1] -= c1 * y0 + c3 * y1;
        left = later;
    }
    let mut promise = S::ZERO;
    let mut after = [S::ZERO; 2];
    for here in work.iter_mut().rev() {
        let Work { block, gradient, coupling, .. } = *here;
        // Before it is overwritten: y^T D^-1 y sums to gradient . step.
        let u = gradient[0];
        let v = gradient[1] - block[1] * gradient[0];
        promise += u * u / block[0] + v * v / block[2];
        let r0 = gradient[0] - (coupling[0] * after[0] + coupling[1] * after[1]);
        let r1 = gradient[1] - (coupling[2] * after[0] + coupling[3] * after[1]);
        let (x, y) = solve_block(block[0], block[1], block[2], r0, r1);
        here.gradient = [x, y];
        after = [x, y];
    }
    promise
}

/// Solves L D L^T x = r for a 2 x 2 block.
#[inline]
fn solve_block<S: Scalar>(d0: S, lower: S, d1: S, r0: S, r1: S) -> (S, S) {
    let y = (r1 - lower * r0) / d1;
    (r0 / d0 - lower * y, y)
}
