//! The Newton system: block tridiagonal, with one 2 x 2 block per station, each coupled to the next.

use crate::number::Scalar;
use crate::number::list::part;
use crate::servo::piece::Slot;
use core::ops::Range;

/// What a station's rows have on the diagonal and on the right-hand side.
#[derive(Clone, Copy, Debug)]
pub struct Diagonal<S> {
    /// Block: bb, ba, aa.
    pub block: [S; 3],
    /// Right-hand side.
    pub gradient: [S; 2],
}

impl<S: Scalar> Diagonal<S> {
    pub const EMPTY: Self = Self { block: [S::ZERO; 3], gradient: [S::ZERO; 2] };

    /// Of a station that is not free: its step is 0.
    pub const FIXED: Self = Self { block: [S::ONE, S::ZERO, S::ONE], gradient: [S::ZERO; 2] };

    /// What a station with these rows, factored, takes of those of the next one.
    #[inline]
    fn takes(self, [c0, c1, c2, c3]: [S; 4]) -> Self {
        // Columns of block^-1 coupling.
        let [x0, x2] = solve_block(self.block, [c0, c2]);
        let [x1, x3] = solve_block(self.block, [c1, c3]);
        let [y0, y1] = solve_block(self.block, self.gradient);
        Self {
            block: [c0 * x0 + c2 * x2, c0 * x1 + c2 * x3, c1 * x1 + c3 * x3],
            gradient: [c0 * y0 + c2 * y1, c1 * y0 + c3 * y1],
        }
    }

    #[inline]
    fn of<const N: usize>(slot: &Slot<S, N>) -> Self {
        let [b, c, d, u, v] = slot.five();
        Self { block: [b, c, d], gradient: [u, v] }
    }

    #[inline]
    fn keep<const N: usize>(self, slot: &Slot<S, N>) {
        let Self { block: [b, c, d], gradient: [u, v] } = self;
        slot.keep_five([b, c, d, u, v]);
    }
}

/// The rows of all stations of a window, and their steps: they lie in slots of pieces that hold none.
#[derive(Clone, Copy)]
pub struct Rows<'a, S: Scalar, const N: usize> {
    slots: &'a [Slot<S, N>],
}

impl<'a, S: Scalar, const N: usize> Rows<'a, S, N> {
    /// No room for any: every step is 0.
    pub const NONE: Self = Self { slots: &[] };

    pub const fn new(slots: &'a [Slot<S, N>]) -> Self {
        Self { slots }
    }

    /// What a station's rows have on the diagonal and on the right-hand side.
    #[inline]
    pub fn diagonal(&self, i: usize) -> Option<Diagonal<S>> {
        self.slots.get(i).map(Diagonal::of)
    }

    /// Keeps what a station's rows have on the diagonal and on the right-hand side.
    #[inline]
    pub fn keep(&self, i: usize, diagonal: Diagonal<S>) {
        if let Some(slot) = self.slots.get(i) {
            diagonal.keep(slot);
        }
    }

    /// Factors a station's rows, with the coupling of its (b, a) with the next one's, row by row: `taken` is what the station before
    /// takes of them. Returns what is taken of the next one's.
    ///
    /// This is an L D L^T factorisation block by block (the Thomas algorithm of a positive definite matrix).
    #[inline]
    pub fn eliminate(
        &self,
        i: usize,
        Diagonal { block: [bb, ba, aa], gradient: [b, a] }: Diagonal<S>,
        coupling: [S; 4],
        taken: Diagonal<S>,
    ) -> Diagonal<S> {
        let tiny = S::EPSILON * S::of(LEAST_PIVOT);
        let [less_bb, less_ba, less_aa] = taken.block;
        let gradient = [b - taken.gradient[0], a - taken.gradient[1]];
        let bb = (bb - less_bb).greatest(bb * tiny);
        let ba = ba - less_ba;
        let aa = (aa - less_aa).greatest(aa * tiny);
        // L D L^T of the 2 x 2 block.
        let lower = ba / bb;
        let rest = (aa - ba * lower).greatest(aa * tiny);
        let factored = Diagonal { block: [bb, lower, rest], gradient };
        if let Some(slot) = self.slots.get(i) {
            factored.keep(slot);
            slot.keep_four(coupling);
        }
        factored.takes(coupling)
    }

    /// What a station that has been factored takes of the rows of the next one.
    pub fn taken(&self, i: usize) -> Option<Diagonal<S>> {
        let slot = self.slots.get(i)?;
        Some(Diagonal::of(slot).takes(slot.four()))
    }

    /// The step of a station.
    #[inline]
    pub fn step(&self, i: usize) -> [S; 2] {
        self.slots.get(i).map_or([S::ZERO; 2], Slot::two)
    }

    #[inline]
    pub fn set_step(&self, i: usize, step: [S; 2]) {
        if let Some(slot) = self.slots.get(i) {
            slot.keep_two(step);
        }
    }

    /// Solves the system of some stations, all of which have been factored: the solution becomes their steps. The step of the one
    /// behind them is 0.
    /// Returns gradient . step, the square of the Newton decrement.
    ///
    /// Cost, with the factorisation: about 60 multiplications and 12 divisions per station.
    pub fn solve(&self, stations: Range<usize>) -> S {
        let slots = part(self.slots, stations);
        let mut decrement = S::ZERO;
        let mut after = [S::ZERO; 2];
        for slot in slots.iter().rev() {
            let Diagonal { block, gradient } = Diagonal::of(slot);
            let coupling = slot.four();
            // y^T D^-1 y sums to gradient . step.
            let u = gradient[0];
            let v = gradient[1] - block[1] * gradient[0];
            decrement += u * u / block[0] + v * v / block[2];
            let r0 = gradient[0] - (coupling[0] * after[0] + coupling[1] * after[1]);
            let r1 = gradient[1] - (coupling[2] * after[0] + coupling[3] * after[1]);
            after = solve_block(block, [r0, r1]);
            slot.keep_two(after);
        }
        decrement
    }
}

/// Rounding errors that a pivot keeps of its diagonal element at least: a system that rounding has made
/// singular gives a long step, which the line search shortens, and no infinite one.
const LEAST_PIVOT: f64 = 16.0;

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
        let system: [(Diagonal<f64>, [f64; 4]); 5] = core::array::from_fn(|i| {
            let x = 1.0 + i as f64;
            let diagonal =
                Diagonal { block: [8.0 + x, 1.0 - 0.3 * x, 9.0], gradient: [x, 2.0 - x] };
            (diagonal, if i < 4 { [0.5 * x, -1.0, 0.25, 1.5] } else { [0.0; 4] })
        });
        let slots = [const { Slot::<f64, 1>::EMPTY }; 7];
        let rows = Rows::new(&slots);
        let mut taken = Diagonal::EMPTY;
        for (i, (diagonal, coupling)) in system.iter().enumerate() {
            taken = rows.eliminate(i + 1, *diagonal, *coupling, taken);
            let kept = rows.taken(i + 1).unwrap();
            assert_eq!(kept.block.map(f64::to_bits), taken.block.map(f64::to_bits));
        }
        let decrement = rows.solve(1..6);
        assert_eq!((rows.step(0), rows.step(6)), ([0.0; 2], [0.0; 2]), "beside the system");
        let mut sum = 0.0;
        for i in 0..5 {
            let x = |k: usize| if k < 5 { rows.step(k + 1) } else { [0.0; 2] };
            let [bb, ba, aa] = system[i].0.block;
            let (here, next) = (x(i), x(i + 1));
            let c = system[i].1;
            let mut left = [
                bb * here[0] + ba * here[1] + c[0] * next[0] + c[1] * next[1],
                ba * here[0] + aa * here[1] + c[2] * next[0] + c[3] * next[1],
            ];
            if i > 0 {
                let (c, before) = (system[i - 1].1, x(i - 1));
                left[0] += c[0] * before[0] + c[2] * before[1];
                left[1] += c[1] * before[0] + c[3] * before[1];
            }
            for k in 0..2 {
                assert!((left[k] - system[i].0.gradient[k]).abs() < 1e-12, "{i} {k}: {left:?}");
                sum += system[i].0.gradient[k] * here[k];
            }
        }
        assert!((sum - decrement).abs() < 1e-12 * sum.abs(), "{sum} {decrement}");
    }

    /// Rounding can make a pivot vanish or worse: the step stays a number.
    #[test]
    fn a_singular_block_gives_a_finite_step() {
        let diagonal = Diagonal { block: [1.0f32, 1.0, 1.0], gradient: [1.0, -1.0] };
        let slots = [const { Slot::<f32, 3>::EMPTY }; 2];
        let rows = Rows::new(&slots);
        let taken = rows.eliminate(0, diagonal, [0.0; 4], Diagonal::EMPTY);
        rows.eliminate(1, diagonal, [0.0; 4], taken);
        assert!(rows.solve(0..2).is_finite());
        assert!((0..2).all(|i| rows.step(i).iter().all(|x| x.is_finite())));
    }
}
