//! Probes: G38.2 to G38.5, from the line to its answer (feature `probe`).

use super::code::{Alarm, Error};
use super::lines::place_of;
use super::station::{Doing, Station, own};
use crate::gcode::ProbeMove;
use crate::jog::{Outcome, Probe, ProbeError};
use crate::number::{Coord, Scalar};
use crate::planner::Planner;
use crate::servo::Input;

/// A probe as the planner takes it.
fn probe<S: Scalar, const N: usize>(asked: &ProbeMove) -> Probe<S, N> {
    let to = own(&asked.to);
    Probe { to, feed: S::of(asked.feed), input: Input::Probe, closes: asked.closes }
}

impl<S: Scalar, const N: usize> Station<S, N> {
    /// Whether the planner would take the probe that a line asks for.
    pub(super) fn check_probe<const BLOCKS: usize, const NODES: usize>(
        asked: &ProbeMove,
        from: &[Coord; N],
        planner: &Planner<'_, S, N, BLOCKS, NODES>,
    ) -> Result<(), Error> {
        planner.check_probe(&probe(asked), from).map_err(|error| Error::of_probe(&error))
    }

    /// Comes to a probe: everything before it is done first.
    pub(super) fn begin_probe(&mut self, asked: &ProbeMove) {
        if self.check {
            // As if there were no contact.
            self.reader.set_position(&asked.to);
            self.doing = Doing::Line { waiting: None };
        } else {
            self.doing = Doing::Probing { asked: *asked, begun: false };
        }
    }

    /// Waits for the machine to rest, probes, and goes on from where it then stands. Whether more could be done at once.
    pub(super) fn go_on_probing<const BLOCKS: usize, const NODES: usize>(
        &mut self,
        asked: &ProbeMove,
        begun: bool,
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
    ) -> bool {
        if !begun {
            return self.start_probe(asked, planner);
        }
        if planner.is_jogging() {
            return false;
        }
        let Some(probed) = planner.probed() else { return false };
        let found = probed.outcome == Outcome::Tripped;
        self.probed = (probed.position, found);
        if !found && asked.required {
            self.alarm(Alarm::ProbeContact, planner.controls());
            self.say_probed();
            self.end_probe();
            return false;
        }
        self.say_probed();
        self.reader.set_position(&place_of(planner.end()));
        self.doing = Doing::Line { waiting: None };
        true
    }

    fn start_probe<const BLOCKS: usize, const NODES: usize>(
        &mut self,
        asked: &ProbeMove,
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
    ) -> bool {
        if !planner.is_empty() {
            // No more blocks come before the probe.
            planner.finish();
            return false;
        }
        match planner.probe(&probe(asked)) {
            Ok(()) => {
                self.doing = Doing::Probing { asked: *asked, begun: true };
                true
            }
            Err(ProbeError::Running | ProbeError::Held | ProbeError::Aborted) => false,
            Err(ProbeError::Input) => {
                self.alarm(Alarm::ProbeInitial, planner.controls());
                self.end_probe();
                false
            }
            // It has been looked at when the line was read, from where the line begins: the machine stands elsewhere.
            Err(error) => {
                self.reader.restore(&self.before);
                self.doing = Doing::Nothing;
                self.answer(Err(Error::of_probe(&error)));
                true
            }
        }
    }

    /// As in grbl the line of a probe that has ended in an alarm has been done.
    fn end_probe(&mut self) {
        self.doing = Doing::Nothing;
        self.answer(Ok(()));
    }
}
