//! How far blocks go as they are programmed, and how far they have been cut: which place on the path stands for the end
//! of a block (feature `outputs`).
//!
//! Every cell is made from a stretch of the programmed path, known to the unit: of a line or an arc the same length, of a
//! corner what lies beside its nodes, of a blend equal parts of what the joint takes of either side, of a run the part of its
//! poly-line beside a span, which may have slipped along it. So a place between two blocks, counted as they are programmed, lies in one cell, or
//! at a node; within a cell both lengths are taken in proportion, in a run by the foot on its chord. The end of a block with a rounded corner is the middle
//! of the rounding.

use crate::number::Length;
use heapless::Deque;

/// Vertices of a run that are kept until they are cut. Of more, those between are taken in proportion.
const VERTICES: usize = 48;

/// A place on the programmed path: its length from the start, in units of 2^17 * 1e-12 mm, modulo 2^64 of them, and how
/// many standstills come before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Milestone {
    pub length: i64,
    pub stands: u32,
}

impl Milestone {
    /// Whether it lies before another.
    pub const fn is_before(self, other: Self) -> bool {
        let ahead = other.length.wrapping_sub(self.length);
        ahead > 0 || (ahead == 0 && other.stands.wrapping_sub(self.stands).cast_signed() > 0)
    }
}

/// Lengths as they are added up: rounding down, the same of equal lengths.
const fn units(length: Length) -> i64 {
    length.raw() >> 17
}

/// The counter.
pub struct Meter {
    /// Start and end of the last block that was taken.
    from: Milestone,
    taken: Milestone,
    /// Start of the front block.
    front: i64,
    /// End of the last cell.
    cut: Milestone,
    /// Vertices of the run that have not been cut: place in the run, on the programmed path.
    vertices: Deque<(Length, i64), VERTICES>,
}

impl Meter {
    pub const fn new() -> Self {
        let zero = Milestone { length: 0, stands: 0 };
        Self { from: zero, taken: zero, front: 0, cut: zero, vertices: Deque::new() }
    }

    /// Forgets what has not been cut.
    pub fn clear(&mut self) {
        self.vertices.clear();
        (self.from, self.taken, self.front) = (self.cut, self.cut, self.cut.length);
        self.taken.stands = self.cut.stands;
    }

    /// Where the last block that was taken begins.
    pub const fn from(&self) -> Milestone {
        self.from
    }

    /// Where it ends.
    pub const fn taken(&self) -> Milestone {
        self.taken
    }

    /// Where the last cell ends.
    pub const fn cut(&self) -> Milestone {
        self.cut
    }

    /// A block is to be taken.
    pub const fn begin(&mut self) {
        self.from = self.taken;
    }

    /// A block, or a part of one, has been taken.
    pub const fn take(&mut self, length: Length) {
        self.taken.length = self.taken.length.wrapping_add(units(length));
    }

    /// The last block has become longer.
    pub const fn lengthen(&mut self, before: Length, after: Length) {
        let more = units(after) - units(before);
        self.taken.length = self.taken.length.wrapping_add(more);
    }

    /// A standstill has been taken.
    pub const fn take_stand(&mut self) {
        self.taken.stands = self.taken.stands.wrapping_add(1);
    }

    /// A standstill has been cut.
    pub const fn cut_stand(&mut self) {
        self.cut.stands = self.cut.stands.wrapping_add(1);
    }

    /// The front block has been cut, but for what its joint gives to the next.
    pub const fn pass(&mut self, length: Length) {
        self.front = self.front.wrapping_add(units(length));
    }

    /// Cut up to a place on the front block.
    pub const fn cut_to(&mut self, s: Length) {
        self.cut.length = self.front.wrapping_add(units(s));
    }

    /// Cut up to a place behind the front block, of some `length`.
    pub const fn cut_beyond(&mut self, length: Length, s: Length) {
        self.cut.length = self.front.wrapping_add(units(length)).wrapping_add(units(s));
    }

    /// A run begins at a place on the front block.
    pub fn begin_run(&mut self, s: Length) {
        self.vertices.clear();
        self.add_vertex(Length::ZERO, s);
    }

    /// The run goes to a place on the front block, which is `reach` from its start.
    pub fn add_vertex(&mut self, reach: Length, s: Length) {
        let vertex = (reach, self.front.wrapping_add(units(s)));
        if self.vertices.is_full() {
            self.vertices.pop_back();
        }
        // There is room.
        let _ = self.vertices.push_back(vertex);
    }

    /// Cut up to a place in the run.
    pub fn cut_run(&mut self, s: Length) {
        // The vertex before, and the one behind.
        while self.vertices.get(1).is_some_and(|next| next.0 <= s) {
            self.vertices.pop_front();
        }
        let Some((from, length)) = self.vertices.front().copied() else { return };
        let (step, mut beyond) = (s - from, 0);
        if let Some((to, end)) = self.vertices.get(1).copied()
            && step > Length::ZERO
            && step < to - from
        {
            let share = step.share_of(to - from) as f64 * (1.0 / (1_u64 << 62) as f64);
            beyond = (end.wrapping_sub(length) as f64 * share) as i64;
        }
        let cut = length.wrapping_add(beyond);
        // A spline does not go back.
        if cut.wrapping_sub(self.cut.length) > 0 {
            self.cut.length = cut;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mm(x: f64) -> Length {
        Length::from_mm(x)
    }

    #[test]
    fn a_run_is_cut_at_its_vertices_and_in_proportion_between() {
        let mut meter = Meter::new();
        for length in [1.0, 2.0, 4.0] {
            meter.begin();
            meter.take(mm(length));
        }
        meter.begin_run(mm(0.5));
        meter.add_vertex(mm(0.25), mm(1.0));
        meter.pass(mm(1.0));
        meter.add_vertex(mm(2.25), mm(2.0));
        for (s, there) in [(0.125, 0.75), (0.25, 1.0), (1.25, 2.0), (2.25, 3.0)] {
            meter.cut_run(mm(s));
            let error = meter.cut().length - units(mm(there));
            assert!(error.abs() <= 3, "{s} {error}");
        }
        assert_eq!(meter.cut().length, units(mm(1.0)) + units(mm(2.0)));
    }

    #[test]
    fn standstills_order_what_lies_at_one_place() {
        let mut meter = Meter::new();
        meter.take(mm(3.0));
        let before = meter.taken();
        meter.take_stand();
        let behind = meter.taken();
        assert!(before.is_before(behind) && !behind.is_before(before));
        meter.cut_to(mm(3.0));
        assert!(meter.cut() == before && meter.cut().is_before(behind));
        meter.cut_stand();
        assert_eq!(meter.cut(), behind);
    }
}
