//! Taking blocks in: the look-ahead grows, or its last line becomes longer.

use super::{Builder, Stage};
use crate::block::{Block, Motion, PushError};
use crate::machine::{Config, CornerMode, Ramp};
use crate::number::Length;
use crate::number::Scalar;
use crate::number::vector::{norm, sub};
use crate::path::budget::Straightened;
use crate::path::chords::Chords;
#[cfg(feature = "outputs")]
use crate::path::feed;
use crate::path::joint::{goes_on_from, joint};
#[cfg(feature = "shaping")]
use crate::path::node::Event;
use crate::path::queued::{Joint, QueuedBlock};
use crate::path::segment::Segment;
use crate::path::straight::{Mark, SHOWN_SHARE, Sleeve};

/// Rounding of the turn between two lines, in units of the scalar's.
const TURN_ROUNDING: f64 = 16.0;

/// The last block with a line that runs straight on from it.
struct Longer<S, const N: usize> {
    block: QueuedBlock<S, N>,
    sleeve: Sleeve<N>,
    /// The mark between the two, if that is to be shown.
    mark: Option<Mark<S>>,
}

/// How a line runs straight on from the last block.
enum Onward<S, const N: usize> {
    /// It becomes a part of it.
    Part(Longer<S, N>),
    /// It is the next.
    Next,
}

impl<S: Scalar, const N: usize, const BLOCKS: usize> Builder<S, N, BLOCKS> {
    /// Takes a block, or leaves everything as it was.
    pub fn push(&mut self, block: &Block<S, N>, config: &Config<S, N>) -> Result<(), PushError> {
        self.take_chord(config);
        if self.is_full() {
            return Err(PushError::Full);
        }
        #[cfg(feature = "outputs")]
        self.meter.begin();
        if matches!(block.motion, Motion::Cubic { .. }) {
            return self.take_curve(block, config);
        }
        self.take(block, None, config)
    }

    /// Takes a curve for which there is room, or leaves everything as it was.
    #[inline(never)]
    fn take_curve(&mut self, block: &Block<S, N>, config: &Config<S, N>) -> Result<(), PushError> {
        let reject = |reason| PushError::Rejected { tag: block.tag, reason };
        let Some(chords) = Chords::new(self.end, block, config).map_err(reject)? else {
            return self.take(block, None, config);
        };
        // The first chord is checked as the block is, by its feed; the others are what it is.
        self.take(&chords.line(), Some(chords.whole()), config)?;
        self.chords.set(chords.advanced());
        Ok(())
    }

    /// Takes a chord of the curve that was accepted last, if there is room. Returns whether it did.
    #[inline(never)]
    pub(super) fn take_chord(&mut self, config: &Config<S, N>) -> bool {
        let Some(chords) = self.chords.as_ref() else { return false };
        if self.queue.is_full() {
            return false;
        }
        let (line, whole) = (chords.line(), chords.whole());
        // Its fields are those of the first, and its end lies between control points.
        let taken = self.take(&line, Some(whole), config);
        debug_assert!(taken.is_ok(), "a chord of a curve that was accepted is refused");
        let rest = self.chords.as_ref().and_then(Chords::advanced);
        self.chords.set(rest);
        true
    }

    /// Takes a block for which there is room, or leaves everything as it was. `whole` is the length of the
    /// curve that it is a part of, mm.
    #[inline(never)]
    fn take(
        &mut self,
        block: &Block<S, N>,
        whole: Option<S>,
        config: &Config<S, N>,
    ) -> Result<(), PushError> {
        // Used where it has been made: a copy of it is some two hundred instructions.
        let mut made = QueuedBlock::new(self.end, block, whole, config);
        let item = match &mut made {
            Ok(Some(item)) => item,
            Ok(None) => {
                // Zero length: nothing to do but to honour an exact stop.
                if block.exact_stop
                    && let Some(last) = self.queue.back_mut()
                {
                    last.stop_after = true;
                }
                return Ok(());
            }
            Err(reason) => {
                return Err(PushError::Rejected { tag: block.tag, reason: *reason });
            }
        };
        item.limits = self.limits;
        #[cfg(feature = "shaping")]
        {
            if item.segment.is_some() && (item.alone || self.after_alone) {
                item.dwell = config.settle();
            }
            self.after_alone = item.alone && item.segment.is_some();
            // It counts from when everything rests: behind another standstill, from its beginning. In a pause the machine may be jogged.
            let stands = item.segment.is_none();
            if stands && !self.stands {
                item.dwell = item.dwell + config.settle();
            }
            self.stands = stands && item.event != Some(Event::Pause);
        }
        #[cfg(feature = "limits")]
        {
            self.limits_used = true;
        }
        self.closed = false;
        #[cfg(feature = "outputs")]
        if let Some(segment) = &item.segment {
            self.asked = feed::programmed_speed(segment, whole, block.feed, &config.limits);
        }
        if let Some(segment) = &item.segment {
            self.end = segment.end;
        }
        match self.longer(item, config) {
            Some(Onward::Part(longer)) => {
                self.lengthen(&longer, config);
                return Ok(());
            }
            Some(Onward::Next) => {
                if let Some(last) = self.queue.back_mut() {
                    last.goes_on = true;
                }
            }
            None => {}
        }
        self.capped = false;
        #[cfg(feature = "outputs")]
        match &item.segment {
            Some(segment) => self.meter.take(segment.exact_length),
            None => self.meter.take_stand(),
        }
        self.sleeve.set(None);
        // The joint behind a block that is being cut has been decided, unless a run goes on.
        if (self.waits() || self.queue.len() > 1)
            && let Some(last) = self.queue.back_mut()
        {
            (last.joint, last.want) = joint(last, item, config);
        }
        let taken = self.queue.push_back(*item);
        debug_assert!(taken.is_ok(), "room was checked");
        Ok(())
    }

    /// Whether the last block may still become longer; `exact`: without turning.
    fn last_is_open(&self, exact: bool) -> bool {
        let Some(front) = self.queue.front() else { return false };
        match (self.queue.len(), self.stage) {
            (1, Stage::Waiting) => exact || self.entrance.is_rest(),
            (1, Stage::Run { until: None }) => exact || self.entrance.taken == Length::ZERO,
            (1, _) => false,
            // What the joint behind the front block takes of the last has been decided.
            (2, _) if !self.waits() => match front.joint {
                Joint::Stop | Joint::Run => true,
                Joint::Corner | Joint::Blend => exact,
                Joint::Through => exact && front.goes_on,
            },
            _ => true,
        }
    }

    /// The last block becomes longer.
    #[inline(never)]
    fn lengthen(
        &mut self,
        &Longer { block: ref longer, sleeve, mark }: &Longer<S, N>,
        config: &Config<S, N>,
    ) {
        if let Some(mark) = mark {
            self.marks.push(mark);
        }
        self.sleeve.set(Some(sleeve));
        if let Some(last) = self.queue.back_mut() {
            #[cfg(feature = "outputs")]
            if let (Some(before), Some(after)) = (&last.segment, &longer.segment) {
                self.meter.lengthen(before.exact_length, after.exact_length);
            }
            *last = *longer;
        }
        // The joint behind a block that is being cut has been decided, unless a run goes on.
        if let Some(n) = self.queue.len().checked_sub(2)
            && (n > 0 || self.waits())
            && let Some(before) = self.queue.get_mut(n)
        {
            (before.joint, before.want) = joint(before, longer, config);
        }
    }

    /// Whether the last block may become no longer, though a line runs straight on from it: its joint to that is passed.
    fn last_is_capped(&self) -> bool {
        let Some(front) = self.queue.front() else { return false };
        match (self.queue.len(), self.stage) {
            (1, Stage::Waiting) => self.capped || self.entrance.joint == Joint::Through,
            (1, Stage::Run { until: None }) => self.capped,
            (1, _) => false,
            (2, _) if !self.waits() => self.capped || front.goes_on,
            _ => self.capped,
        }
    }

    /// How a line goes on from the last block, if it runs straight on from it: as a part, with the mark between them if that is
    /// to be shown, or as the next. At equal feed, tolerance and kind only, where no stop is asked for.
    #[inline(never)]
    fn longer(&self, item: &QueuedBlock<S, N>, config: &Config<S, N>) -> Option<Onward<S, N>> {
        let last =
            self.queue.back().filter(|last| last.runs_on(item) && !self.parts(last, item))?;
        let (before, after) = (last.segment.as_ref()?, item.segment.as_ref()?);
        let lines = before.is_line() && after.is_line() && config.corner == CornerMode::Band;
        if !lines {
            return None;
        }
        let shorter = before.length.least(after.length);
        let slack = Straightened::new(item.tolerance, shorter);
        // The vertex lies at least half the turn times the shorter line off the line past it. Most lines turn by
        // far more, and what follows is done in `f64`, which the target has no instructions for.
        let turn = norm(&sub(&after.start_frame().tangent, &before.end_frame().tangent));
        let least = S::of(2.0 * slack.rounded) / shorter;
        if turn > least + S::EPSILON * S::of(TURN_ROUNDING) {
            return None;
        }
        let sleeve = self.sleeve.as_ref().copied();
        let (sleeve, error) = sleeve
            .unwrap_or_else(|| Sleeve::of(&before.start, &before.end))
            .extended(&before.start, &before.end, &after.end, slack)?;
        let exact = error <= slack.exact;
        if self.capped || !self.last_is_open(exact) {
            let long = before.length >= goes_on_from(before, last.feed, config);
            return (long && self.last_is_capped()).then_some(Onward::Next);
        }
        let begun = match last.marks {
            0 => S::ZERO,
            _ => self.marks.get(self.marks.len().checked_sub(1)?)?.s,
        };
        let piece = before.length - begun;
        // Without room for a mark the piece is shown as a part of the next.
        let shown = last.tag != item.tag
            && piece >= least_piece(before, last.feed, config)
            && !self.marks.is_full();
        let off = if exact { 0.0 } else { error };
        let block = QueuedBlock {
            segment: Some(Segment::line(before.start, after.end)?),
            feed: last.feed.least(item.feed),
            linear: last.linear.with(item.linear),
            stop_after: item.stop_after,
            tag: item.tag,
            marks: last.marks + u16::from(shown),
            error: Straightened::taken(item.tolerance, S::of(off).greatest(last.error)),
            ..*last
        };
        let mark = shown.then_some(Mark { s: before.length, tag: last.tag });
        Some(Onward::Part(Longer { block, sleeve, mark }))
    }
}

/// Length of the shortest piece of a line whose tag is shown, mm: a servo cycle at the feed at least.
pub(super) fn least_piece<S: Scalar, const N: usize>(
    segment: &Segment<S, N>,
    feed: S,
    config: &Config<S, N>,
) -> S {
    let ramp = Ramp::new(&config.limits, &segment.start_frame().tangent).length(feed);
    (feed * config.cycle).greatest(ramp * S::of(SHOWN_SHARE))
}
