//! A symmetric system in which every block is coupled with the three before it.

use super::COUPLED;
use super::vector::dot;
use crate::number::Scalar;

/// A pivot of which less is left than so many roundings is none.
const ROUNDING: f64 = 2.0;

/// `N` by `N` numbers.
pub(super) type Square<S, const N: usize> = [[S; N]; N];

/// Lower half: of each row of blocks the block on the diagonal and those up to three before it. Every block is symmetric, and until
/// the matrix is factored only its lower half counts.
#[derive(Clone, Debug)]
pub(super) struct Banded<S, const N: usize, const K: usize> {
    pub(super) blocks: [[Square<S, N>; COUPLED]; K],
}

impl<S: Scalar, const N: usize, const K: usize> Banded<S, N, K> {
    pub(super) const fn new() -> Self {
        Self { blocks: [[[[S::ZERO; N]; N]; COUPLED]; K] }
    }

    /// The first `count` rows.
    pub(super) fn clear(&mut self, count: usize) {
        self.blocks[..count].fill([[[S::ZERO; N]; N]; COUPLED]);
    }

    /// Block (`row`, `column`), columns up to three before the row, times a vector, added to another.
    pub(super) fn times(&self, row: usize, column: usize, x: &[S; N], to: &mut [S; N]) {
        let (low, high) = (row.min(column), row.max(column));
        if high - low >= COUPLED {
            return;
        }
        let block = &self.blocks[high][high - low];
        for i in 0..N {
            for j in 0..N {
                to[i] += block[i.max(j)][i.min(j)] * x[j];
            }
        }
    }

    /// Factors the blocks of `first..end`, in place. Whether the matrix is positive definite.
    ///
    /// Cost: about `N^3 * 7` multiplications a block.
    pub(super) fn factor(&mut self, first: usize, end: usize) -> bool {
        for row in first..end {
            let (done, rest) = self.blocks.split_at_mut(row);
            let blocks = &mut rest[0];
            let reach = (row - first).min(COUPLED - 1);
            for back in (1..=reach).rev() {
                let column = &done[row - back];
                let mut block = whole(&blocks[back]);
                for before in back + 1..=reach {
                    // Column `row - before` of both rows.
                    let (ours, theirs) = (&blocks[before], &column[before - back]);
                    for i in 0..N {
                        for j in 0..N {
                            block[i][j] = block[i][j] - dot(&ours[i], &theirs[j]);
                        }
                    }
                }
                // Times the inverse of the transposed factor of that column, which lies on its diagonal.
                let diagonal = &column[0];
                for line in &mut block {
                    for j in 0..N {
                        let mut sum = line[j];
                        for k in 0..j {
                            sum = sum - line[k] * diagonal[j][k];
                        }
                        line[j] = sum * diagonal[j][j];
                    }
                }
                blocks[back] = block;
            }
            let mut block = blocks[0];
            for before in 1..=reach {
                let ours = &blocks[before];
                for i in 0..N {
                    for j in 0..=i {
                        block[i][j] = block[i][j] - dot(&ours[i], &ours[j]);
                    }
                }
            }
            if !square_root(&mut block, &blocks[0]) {
                return false;
            }
            blocks[0] = block;
        }
        true
    }

    /// Solves for two right sides in `first..end`, in place, half the way: [`Banded::backward`] is the other half. After
    /// [`Banded::factor`].
    pub(super) fn forward(
        &self,
        first: usize,
        end: usize,
        x: &mut [[S; N]; K],
        y: &mut [[S; N]; K],
    ) {
        for row in first..end {
            let (mut a, mut b) = (x[row], y[row]);
            for back in 1..=(row - first).min(COUPLED - 1) {
                let block = &self.blocks[row][back];
                let (x, y) = (&x[row - back], &y[row - back]);
                for i in 0..N {
                    for k in 0..N {
                        a[i] = a[i] - block[i][k] * x[k];
                        b[i] = b[i] - block[i][k] * y[k];
                    }
                }
            }
            let diagonal = &self.blocks[row][0];
            for i in 0..N {
                for k in 0..i {
                    a[i] = a[i] - diagonal[i][k] * a[k];
                    b[i] = b[i] - diagonal[i][k] * b[k];
                }
                a[i] = a[i] * diagonal[i][i];
                b[i] = b[i] * diagonal[i][i];
            }
            (x[row], y[row]) = (a, b);
        }
    }

    /// The other half of the way, for one right side.
    pub(super) fn backward(&self, first: usize, end: usize, x: &mut [[S; N]; K]) {
        for row in (first..end).rev() {
            let mut sum = x[row];
            for ahead in 1..COUPLED.min(end - row) {
                let block = &self.blocks[row + ahead][ahead];
                let x = &x[row + ahead];
                for i in 0..N {
                    for k in 0..N {
                        sum[i] = sum[i] - block[k][i] * x[k];
                    }
                }
            }
            let diagonal = &self.blocks[row][0];
            for i in (0..N).rev() {
                for k in i + 1..N {
                    sum[i] = sum[i] - diagonal[k][i] * sum[k];
                }
                sum[i] = sum[i] * diagonal[i][i];
            }
            x[row] = sum;
        }
    }
}

/// Both halves of a symmetric block of which there is the lower one.
fn whole<S: Scalar, const N: usize>(half: &Square<S, N>) -> Square<S, N> {
    core::array::from_fn(|i| core::array::from_fn(|j| half[i.max(j)][i.min(j)]))
}

/// The factor of a block on the diagonal, what is left of `whole`. Whether that is positive definite.
fn square_root<S: Scalar, const N: usize>(block: &mut Square<S, N>, whole: &Square<S, N>) -> bool {
    let rounding = S::EPSILON * S::of(ROUNDING);
    for j in 0..N {
        for i in j..N {
            let mut sum = block[i][j];
            for k in 0..j {
                sum = sum - block[i][k] * block[j][k];
            }
            if i > j {
                block[i][j] = sum * block[j][j];
                continue;
            }
            if !(whole[j][j] > S::ZERO) {
                return false;
            }
            // Kept as its inverse: divisions are slow. Where rounding is all that is left, that number stays as it is.
            block[j][j] = if sum > whole[j][j] * rounding { S::ONE / sum.sqrt() } else { S::ZERO };
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    const N: usize = 2;
    const K: usize = 12;

    /// A random positive definite system.
    fn random(seed: u32) -> Banded<f64, N, K> {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 24) - 0.5
        };
        let mut all = Banded::new();
        for row in 0..K {
            for back in 0..COUPLED.min(row + 1) {
                for i in 0..N {
                    for j in 0..=i {
                        all.blocks[row][back][i][j] = next();
                    }
                }
            }
            let block = &mut all.blocks[row][0];
            for i in 0..N {
                block[i][i] += 5.0;
            }
        }
        all
    }

    #[test]
    fn solutions_satisfy_the_system() {
        for seed in 0..50 {
            let all = random(seed);
            let (first, end) = (seed as usize % 4, K - seed as usize % 3);
            let right: [[f64; N]; K] = core::array::from_fn(|k| [k as f64 - 3.0, 1.0]);
            let other = right.map(|[a, b]| [b, a * a]);
            let (mut factored, mut x, mut y) = (all.clone(), right, other);
            assert!(factored.factor(first, end));
            factored.forward(first, end, &mut x, &mut y);
            for (right, mut x) in [(right, x), (other, y)] {
                factored.backward(first, end, &mut x);
                for row in first..end {
                    let mut sum = [0.0; N];
                    for column in first..end {
                        all.times(row, column, &x[column], &mut sum);
                    }
                    for i in 0..N {
                        assert!((sum[i] - right[row][i]).abs() < 1e-9, "{seed} {row}");
                    }
                }
            }
        }
    }

    #[test]
    fn what_is_not_positive_definite_is_said() {
        let mut all = random(3);
        all.blocks[7][0][1][1] = -1.0;
        assert!(!all.factor(0, K));
    }
}
