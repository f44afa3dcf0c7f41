//! The pieces of the lines of a run that have tags of their own.

use crate::number::{Interval, Length, Scalar};
use crate::path::straight::{self, NEAR};
use heapless::Vec;

/// Pieces that are remembered; of more, the tag of the next is shown.
const PIECES: usize = 10;

/// A piece of a line with a tag of its own.
#[derive(Clone, Copy)]
struct TaggedPiece<S> {
    /// Where it ends.
    to: Length,
    /// mm.
    length: S,
    tag: u32,
}

impl<S: Scalar> TaggedPiece<S> {
    fn from(&self) -> Length {
        self.to - Length::from_mm(self.length)
    }

    /// Ends it at an arc length, if it does not end before; it may have no length then.
    // By itself, here and below: a loop without it is laid out several times over.
    #[inline(never)]
    fn end_by(&mut self, s: Length) {
        let beyond = (self.to - s).max(Length::ZERO);
        self.to = self.to - beyond;
        self.length = self.length - beyond.to_mm();
    }

    /// Whether it ends within a span, but where no cell can be cut, or is shorter than so many mm.
    #[inline(never)]
    fn is_hidden(&self, span: Interval, least: S) -> bool {
        let cuts = self.length >= least && straight::cuts(span, self.to);
        self.to > span.from && self.to <= span.to && !cuts
    }

    /// Whether it begins before the end of a line, by more than its rounding.
    fn begins_before(&self, end: Length) -> bool {
        self.from() + Length::from_mm(self.length * S::EPSILON) < end
    }
}

/// The pieces that no span has shown, in order, and before them those at whose ends cells may still end.
pub struct Pieces<S> {
    list: Vec<TaggedPiece<S>, { PIECES + 1 }>,
    /// Where the last of those ends that were to be taken note of.
    reach: Length,
}

impl<S: Scalar> Pieces<S> {
    pub const fn new() -> Self {
        Self { list: Vec::new(), reach: Length::ZERO }
    }

    pub fn clear(&mut self) {
        self.list.clear();
        self.reach = Length::ZERO;
    }

    /// Takes note of the next piece and its tag. What it begins before ends there: a line that turns back is shorter than it was.
    // Once in the image.
    #[inline(never)]
    pub fn note(&mut self, Interval { from, to }: Interval, tag: u32) {
        self.reach = to;
        for piece in &mut self.list {
            piece.end_by(from);
        }
        self.drop_empty();
        self.insert(TaggedPiece { to, length: (to - from).to_mm(), tag });
    }

    /// Takes note of a line that ends within a span.
    pub fn note_end(&mut self, Interval { from, to }: Interval, tag: u32) {
        if !self.list.iter().any(|piece| piece.to == to) {
            self.insert(TaggedPiece { to, length: (to - from).to_mm(), tag });
        }
    }

    /// Puts a piece in its place. Of more than there is room for the shortest are left out: for them the tag of the next piece of their line is shown.
    #[inline(never)]
    fn insert(&mut self, piece: TaggedPiece<S>) {
        // There is room for one more than are remembered.
        let _ = self.list.push(piece);
        for i in (1..self.list.len()).rev() {
            self.put_in_order(i);
        }
        if self.list.is_full() {
            let mut shortest = self.list.len() - 1;
            for i in 0..self.list.len() {
                if self.is_shorter(i, shortest) {
                    shortest = i;
                }
            }
            if let Some(piece) = self.list.get_mut(shortest) {
                piece.length = S::ZERO;
            }
            self.drop_empty();
        }
    }

    /// Swaps a piece and the one before if they are not in order.
    #[inline(never)]
    fn put_in_order(&mut self, i: usize) {
        if let Some((before, after)) = self.list.split_at_mut_checked(i)
            && let (Some(before), Some(after)) = (before.last_mut(), after.first_mut())
            && before.to > after.to
        {
            core::mem::swap(before, after);
        }
    }

    #[inline(never)]
    fn is_shorter(&self, i: usize, than: usize) -> bool {
        let length = |i: usize| self.list.get(i).map(|piece| piece.length);
        length(i) < length(than)
    }

    /// Forgets the pieces that have no length.
    #[inline(never)]
    fn drop_empty(&mut self) {
        let mut kept = 0;
        for i in 0..self.list.len() {
            if let Some(piece) = self.list.get(i).copied()
                && piece.length > S::ZERO
                && let Some(place) = self.list.get_mut(kept)
            {
                *place = piece;
                kept += 1;
            }
        }
        self.list.truncate(kept);
    }

    /// The same of what is left of a piece behind the last one, if that is more than so many mm.
    #[inline(never)]
    pub fn note_rest(&mut self, Interval { from, to }: Interval, least: S, tag: u32) {
        let from = from.max(self.reach);
        if (to - from).to_mm::<S>() > least {
            self.note(Interval { from, to }, tag);
        }
    }

    /// The tag of what lies around an arc length, if it is not that of its line, which ends at `end` and shows the tag of
    /// its last piece: a piece before that end comes before it.
    pub fn tag_at(&self, s: Length, end: Length) -> Option<u32> {
        let piece = self.list.iter().find(|piece| s < piece.to)?;
        (piece.from() <= s || piece.begins_before(end)).then_some(piece.tag)
    }

    /// Whether any ends up to an arc length.
    pub fn ends_before(&self, s: Length) -> bool {
        self.list.first().is_some_and(|first| first.to <= s)
    }

    /// The end of a piece of at least so many mm that a cell over an interval is cut at, and its tag, if there is one.
    #[inline(never)]
    pub fn end_in(&self, interval: Interval, least: S) -> Option<(Length, u32)> {
        let pieces = self.list.iter().filter(|piece| piece.length >= least);
        straight::end_in(interval, Length::ZERO, pieces.map(|piece| (piece.to, piece.tag)))
    }

    /// The end of a piece of at least so many mm that is near enough to where an interval ends to be its end.
    pub fn end_near(&self, Interval { from, to }: Interval, least: S) -> Option<Length> {
        let near = (to - from) / NEAR;
        let is_near = |p: &&TaggedPiece<S>| p.to - to < near && to - p.to < near;
        self.list.iter().filter(|p| p.length >= least).find(is_near).map(|p| p.to)
    }

    /// A span shows its tag: of what ends beside it, pieces of at least so many mm are kept that a cell can be cut at.
    pub fn shown(&mut self, span: Interval, least: S) {
        for piece in &mut self.list {
            if piece.is_hidden(span, least) {
                piece.length = S::ZERO;
            }
        }
        self.drop_empty();
    }

    /// Forgets what lies before an arc length.
    #[inline(never)]
    pub fn release_before(&mut self, s: Length) {
        for piece in &mut self.list {
            if piece.to <= s {
                piece.length = S::ZERO;
            }
        }
        self.drop_empty();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is left of a piece behind the last is noted if it is long enough.
    #[test]
    fn the_rest_of_a_piece_is_noted_if_it_is_long_enough() {
        let at = |mm: f64| Length::from_mm(mm);
        let mut pieces = Pieces::<f64>::new();
        let whole = Interval { from: at(0.0), to: at(2.0) };
        pieces.note_rest(whole, 2.5, 1);
        assert_eq!(pieces.tag_at(at(1.0), at(3.0)), None);
        pieces.note_rest(whole, 1.5, 1);
        pieces.note_rest(whole, 0.0, 2);
        pieces.note_rest(Interval { to: at(2.5), ..whole }, 0.4, 3);
        let tags = [0.5, 1.9, 2.1].map(|s| pieces.tag_at(at(s), at(3.0)));
        assert_eq!(tags, [Some(1), Some(1), Some(3)]);
    }

    #[test]
    fn tags_are_found_where_their_pieces_lie() {
        let at = |mm: f64| Length::from_mm(mm);
        let piece = |from: f64, to: f64| Interval { from: at(from), to: at(to) };
        let mut pieces = Pieces::<f64>::new();
        pieces.note(piece(1.0, 2.0), 7);
        pieces.note(piece(2.0, 2.5), 8);
        assert_eq!(pieces.list.last().map(|piece| piece.to), Some(at(2.5)));
        let tags = [0.5, 1.0, 1.9, 2.0, 2.5].map(|s| pieces.tag_at(at(s), at(s)));
        assert_eq!(pieces.tag_at(at(0.5), at(1.5)), Some(7), "before the end of the line");
        assert_eq!(tags, [None, Some(7), Some(7), Some(8), None]);
        pieces.release_before(at(2.0));
        assert_eq!(
            (pieces.tag_at(at(1.5), at(1.5)), pieces.tag_at(at(2.2), at(2.2))),
            (None, Some(8))
        );
        // Of more than there is room for the shortest are left out, and the rest stay in order.
        for k in 0..20 {
            pieces.note(piece(3.0 + f64::from(k), 4.0 + f64::from(k)), k);
        }
        assert_eq!(pieces.tag_at(at(3.5), at(3.5)), Some(0));
        assert_eq!(pieces.tag_at(at(22.5), at(22.5)), None);
        pieces.note(piece(30.0, 32.0), 40);
        pieces.note_end(piece(27.0, 29.0), 41);
        let ends = pieces.list.iter().map(|piece| piece.to.to_mm::<f64>());
        assert!(ends.is_sorted());
        assert_eq!(pieces.list.len(), PIECES);
        let shown = [28.0, 31.0].map(|s| pieces.tag_at(at(s), at(33.0)));
        assert_eq!(shown, [Some(41), Some(40)]);
        // For what was left out the next of its line stands.
        assert_eq!(pieces.tag_at(at(22.5), at(33.0)), Some(41));
    }
}
