//! First states for a rest nearer than the one that the states at hand lead to.

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
            let arriving = self.window.get(i - 1).map_or(S::ZERO, |station| station.state.b);
            if y < before && self.is_free(i) {
                self.set_between(i, y * cube_root(y), next * cube_root(next) - arriving);
            }
        }
    }
}
