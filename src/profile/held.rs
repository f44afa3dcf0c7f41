//! First states for a rest nearer than the one that the states at hand lead to.

use super::guess::STEEPEST;
use super::law::PathState;
use super::problem::{Problem, Stretch};
use crate::number::{Scalar, cube_root};

impl<S: Scalar, const N: usize, const NODES: usize> Problem<'_, S, N, NODES> {
    /// Holds the states of the stretch down to what can come to rest at its end. They may break limits then. As for a
    /// guess, in y = v^1.5, of which a motion that comes to rest makes a straight line.
    pub fn hold_down(&mut self) {
        let Stretch { first, last, .. } = self.task.stretch;
        for i in first..=last {
            let (Some(station), Some(row)) = (self.window.get(i), self.rows.get_mut(i)) else {
                return;
            };
            let b = if i == last { S::ZERO } else { station.state.b };
            row.step = [(b * b.sqrt()).sqrt(); 2];
        }
        for i in (first + 1..last).rev() {
            self.rise(i, (i + 1, i));
        }
        for i in first + 1..last {
            let [Some(here), Some(behind)] = [i, i + 1].map(|i| self.rows.get(i)) else { return };
            let ([y, before], [next, _]) = (here.step, behind.step);
            let Some((arriving, station)) = self.window.pair(i - 1) else { return };
            if y < before && self.is_free(i) {
                let b = y * cube_root(y);
                let lengths = [arriving.cell.length, station.cell.length];
                let most = S::of(STEEPEST) * b / lengths[0].greatest(lengths[1]);
                let rise = next * cube_root(next) - arriving.state.b;
                let a = rise * S::of(0.5) / (lengths[0] + lengths[1]);
                self.window.set_state(i, PathState { b, a: a.least(most).greatest(-most) });
            }
        }
    }
}
