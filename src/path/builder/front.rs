//! The front block: when its joint to the next is decided, what that takes of it, and how cutting it starts.

use super::{Body, Builder, ENOUGH, Front, Stage};
use crate::machine::{Config, Ramp};
use crate::number::{Interval, Length, Scalar};
use crate::path::cut::{EndSizes, rest_cell};
use crate::path::joint::{BentLengths, Taken, reach};
use crate::path::queued::Joint;
use crate::path::run::{Start, Tie};
use crate::path::segment::{LEAST_LENGTH, Segment};

/// Share of a line next to a joint that is simply passed which a run leaves alone.
const PASSED_SHARE: i64 = 4;

/// Length of a cell next to a joint that takes so much of a segment, mm: the motion is slow there.
fn beside<S: Scalar, const N: usize>(joint: Joint, taken: Length, segment: &Segment<S, N>) -> S {
    match joint {
        Joint::Corner | Joint::Blend => taken.to_mm::<S>() * S::of(0.5),
        _ => segment.length,
    }
}

impl<S: Scalar, const N: usize, const BLOCKS: usize> Builder<S, N, BLOCKS> {
    /// Whether the joint behind the front block can be decided.
    #[inline(never)]
    pub(super) fn front_is_ready(&self, config: &Config<S, N>) -> bool {
        let Some(item) = self.queue.front() else { return false };
        if item.stop_after || self.queue.len() >= ENOUGH {
            return true;
        }
        match self.queue.get(1) {
            None => self.closed,
            Some(next) => {
                let stops = next.stop_after || next.segment.is_none();
                self.closed || stops || self.parts(item, next) || item.is_gone_on_from(next, config)
            }
        }
    }

    /// Decides the joint behind the front block: how it is, and what it takes of the segment.
    fn decide(&mut self, front: &Front<S, N>, config: &Config<S, N>) -> Joint {
        let Front { block, segment, entrance } = front;
        let next = self.queue.get(1).copied();
        let mut joint = block.joint;
        let ahead = next.as_ref().and_then(|next| next.segment.as_ref());
        let parts = next.as_ref().is_some_and(|next| self.parts(block, next));
        if block.stop_after || parts || ahead.is_none() {
            joint = Joint::Stop;
        }
        let taken = match (joint, &next, ahead) {
            (Joint::Corner | Joint::Blend, Some(next), Some(ahead)) => {
                let last = next.stop_after
                    || next.joint == Joint::Stop
                    || self.queue.get(2).is_none_or(|third| third.segment.is_none());
                reach((block, segment, entrance), (next, ahead, last), joint, config)
            }
            _ => Taken::NONE,
        };
        (self.kept, self.given, self.half) = (taken.before, taken.after, taken.half);
        if matches!(joint, Joint::Corner | Joint::Blend) && self.kept <= Length::ZERO {
            joint = Joint::Stop;
            (self.kept, self.given) = (Length::ZERO, Length::ZERO);
        }
        if let Some(front) = self.queue.front_mut() {
            front.joint = joint;
        }
        joint
    }

    /// Decides the joint behind the front block and starts on its body.
    #[inline(never)]
    pub(super) fn start_front(&mut self, front: &Front<S, N>, config: &Config<S, N>) {
        let mut joint = self.decide(front, config);
        let Front { block, segment, entrance } = front;
        let mut until = entrance.taken;
        if entrance.joint == Joint::Through {
            until += segment.exact_length / PASSED_SHARE;
        }
        if joint == Joint::Run
            && entrance.joint != Joint::Stop
            && segment.exact_length - until < LEAST_LENGTH
        {
            joint = self.stop_behind();
        }
        if joint == Joint::Run {
            let last = (until - entrance.taken).to_mm();
            let first = if entrance.joint == Joint::Through {
                BentLengths::new(segment.length, entrance.length_before).before
            } else {
                last
            };
            self.stage = Stage::Body(Body::new(entrance.taken, until, EndSizes { first, last }));
            return;
        }
        let until = segment.exact_length - self.kept;
        let ahead = self.queue.get(1).and_then(|next| next.segment.as_ref());
        let size = |joint: Joint, kept: Length, neighbour: S| match joint {
            Joint::Stop | Joint::Run => rest_cell(segment, block.feed, &config.limits),
            Joint::Through => BentLengths::new(segment.length, neighbour).before,
            Joint::Corner | Joint::Blend => kept.to_mm::<S>() * S::of(0.5),
        };
        let first = size(entrance.joint, entrance.taken, entrance.length_before);
        let last = size(joint, self.kept, ahead.map_or(S::ZERO, |ahead| ahead.length));
        self.stage = Stage::Body(Body::new(entrance.taken, until, EndSizes { first, last }));
    }

    /// Starts a run `s` along the front segment.
    #[inline(never)]
    pub(super) fn start_run(
        &mut self,
        Front { block, segment, entrance }: &Front<S, N>,
        s: Length,
        config: &Config<S, N>,
    ) {
        let tie = if self.rested { Tie::Rest } else { Tie::Smooth };
        let ramp = Ramp::new(&config.limits, &segment.start_frame().tangent);
        let beside = beside(entrance.joint, entrance.taken, segment);
        let at = segment.node(s).at;
        let before = entrance.tolerance_before.filter(|_| self.rested && s == Length::ZERO);
        self.run.begin(Start { at, tie, ramp, beside, before }, block.leg());
        self.run_from = s;
        #[cfg(feature = "outputs")]
        self.meter.begin_run(s);
        self.stage = Stage::Run { until: None };
    }

    /// Takes the front block into the run, if its joint is known. Returns whether it was.
    #[inline(never)]
    pub(super) fn extend_run(&mut self, front: &Front<S, N>, config: &Config<S, N>) -> bool {
        if !self.front_is_ready(config) {
            return false;
        }
        let mut joint = self.decide(front, config);
        let Front { block, segment, .. } = front;
        if !matches!(joint, Joint::Run | Joint::Stop)
            && self.end_of_run(segment, joint) - self.run_from < LEAST_LENGTH
        {
            joint = self.stop_behind();
        }
        let taken = Interval { from: self.run_from, to: segment.exact_length - self.kept };
        self.mark_run(taken);
        if joint == Joint::Run {
            self.run.push(segment.end, block.leg());
            #[cfg(feature = "outputs")]
            self.meter.add_vertex(self.run.reach(), segment.exact_length);
            self.run_from = Length::ZERO;
            self.next_block(config);
            self.stage = Stage::Run { until: None };
            return true;
        }
        let until = self.end_of_run(segment, joint);
        let tie = if joint == Joint::Stop { Tie::Rest } else { Tie::Smooth };
        let beside = beside(joint, self.kept, segment);
        let mut leg = block.leg();
        leg.programmed.tag = self.tag_at(0, until.to_mm());
        let ahead = self.queue.get(1).filter(|_| joint == Joint::Stop);
        let behind = ahead.map(|next| next.tolerance);
        self.run.finish(segment.node(until).at, leg, tie, (beside, behind));
        #[cfg(feature = "outputs")]
        self.meter.add_vertex(self.run.reach(), until);
        self.stage = Stage::Run { until: Some(until) };
        true
    }

    /// Where on the front segment the run ends if there is this joint behind it.
    fn end_of_run(&self, segment: &Segment<S, N>, joint: Joint) -> Length {
        let until = segment.exact_length - self.kept;
        if joint == Joint::Through { until - segment.exact_length / PASSED_SHARE } else { until }
    }

    /// Stops behind the front block after all: a run that begins or ends in motion does so along a line, and of this one a run
    /// would have less than is a line. It would go on along another, which may lead back.
    #[inline(never)]
    fn stop_behind(&mut self) -> Joint {
        (self.kept, self.given, self.half) = (Length::ZERO, Length::ZERO, None);
        if let Some(front) = self.queue.front_mut() {
            front.joint = Joint::Stop;
        }
        Joint::Stop
    }

    /// The run is done: on with the rest of its last line.
    #[inline(never)]
    pub(super) fn leave_run(&mut self, segment: &Segment<S, N>, s: Length) {
        self.entrance.taken = s;
        self.pass_marks(s);
        let until = segment.exact_length - self.kept;
        let first = (until - s).to_mm();
        let mut last = first;
        if let Some(front) = self.queue.front()
            && front.joint == Joint::Through
            && let Some(ahead) = self.queue.get(1).and_then(|next| next.segment.as_ref())
        {
            last = BentLengths::new(segment.length, ahead.length).before;
        }
        self.stage = Stage::Body(Body::new(s, until, EndSizes { first, last }));
    }
}
