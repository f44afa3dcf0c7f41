//! Probes and homing at the controller's end: they wait until everything before them has been run, and what follows them waits until they
//! are over, for it begins where the machine then stands.

use super::message::Refusal;
#[cfg(feature = "probe")]
use super::seek::ProbeResult;
use super::seek::{HomeMove, ProbeMove, SeekRefusal};
#[cfg(feature = "home")]
use super::seek::{HomeReport, HomeStep};
use super::station::{Station, Waiting};
#[cfg(feature = "home")]
use crate::jog::{AxisHome, HomeFailure};
#[cfg(feature = "probe")]
use crate::jog::{Outcome, Probe, ProbeError, Probed};
use crate::number::Scalar;
use crate::planner::Planner;

/// What is sought.
#[cfg(feature = "probe")]
#[derive(Clone, Copy, Debug)]
enum What<S, const N: usize> {
    /// And whether the session ends if its input does not come.
    Probe(Probe<S, N>, bool),
    #[cfg(feature = "home")]
    Home([Option<AxisHome<S>>; N]),
}

/// A probe or homing that waits, or is under way.
#[cfg(feature = "probe")]
#[derive(Clone, Copy, Debug)]
struct Seek<S, const N: usize> {
    number: u32,
    tag: u32,
    begun: bool,
    what: What<S, N>,
}

/// What came of the last homing, or how far it is.
#[cfg(feature = "home")]
#[derive(Clone, Copy, Debug)]
struct Homed<const N: usize> {
    number: u32,
    tag: u32,
    over: bool,
    steps: [HomeStep; N],
    fault: Option<HomeFailure>,
}

/// Probes and homing of a session.
#[derive(Clone, Copy, Debug)]
pub struct Seeking<S, const N: usize> {
    #[cfg(feature = "probe")]
    seek: Option<Seek<S, N>>,
    #[cfg(feature = "probe")]
    probed: Option<(u32, u32, Probed<N>)>,
    #[cfg(feature = "home")]
    homed: Option<Homed<N>>,
    scalar: core::marker::PhantomData<S>,
}

impl<S, const N: usize> Seeking<S, N> {
    /// None.
    pub const NONE: Self = Self {
        #[cfg(feature = "probe")]
        seek: None,
        #[cfg(feature = "probe")]
        probed: None,
        #[cfg(feature = "home")]
        homed: None,
        scalar: core::marker::PhantomData,
    };

    /// Whether one waits or is under way: nothing more is taken until it is over.
    #[cfg(feature = "probe")]
    pub const fn is_on(&self) -> bool {
        self.seek.is_some()
    }

    #[cfg(not(feature = "probe"))]
    #[allow(clippy::unused_self)]
    pub const fn is_on(&self) -> bool {
        false
    }

    /// What has not begun is dropped; what has is stopped by the abort.
    #[cfg(feature = "probe")]
    pub fn drop_waiting(&mut self) {
        if self.seek.as_ref().is_some_and(|seek| !seek.begun) {
            self.seek = None;
        }
    }

    #[cfg(not(feature = "probe"))]
    #[allow(clippy::unused_self)]
    pub const fn drop_waiting(&mut self) {}

    /// What came of the last probe.
    #[cfg(feature = "probe")]
    pub fn probed(&self) -> Option<ProbeResult> {
        self.probed.as_ref().map(|(number, tag, probed)| ProbeResult::new(*number, *tag, probed))
    }

    #[cfg(not(feature = "probe"))]
    #[allow(clippy::unused_self)]
    pub const fn probed(&self) -> Option<super::seek::ProbeResult> {
        None
    }

    /// How far homing is.
    #[cfg(feature = "home")]
    pub fn homed(&self) -> Option<HomeReport> {
        self.homed.as_ref().map(|homed| HomeReport {
            number: homed.number,
            tag: homed.tag,
            over: homed.over,
            steps: homed.steps.iter().copied().take(9).collect(),
            fault: homed.fault.map(Into::into),
        })
    }

    #[cfg(not(feature = "home"))]
    #[allow(clippy::unused_self)]
    pub const fn homed(&self) -> Option<super::seek::HomeReport> {
        None
    }
}

impl<S: Scalar, const N: usize, const QUEUE: usize> Station<S, N, QUEUE> {
    /// What is sought, as it waits.
    #[cfg(feature = "probe")]
    fn prepare_seek(&mut self, number: u32, tag: u32, what: What<S, N>) -> Waiting<S, N> {
        self.seeking.seek = Some(Seek { number, tag, begun: false, what });
        Waiting::Seek
    }

    /// A probe as it waits.
    #[cfg_attr(not(feature = "probe"), allow(clippy::unused_self))]
    pub(super) fn prepare_probe(
        &mut self,
        number: u32,
        asked: &ProbeMove,
    ) -> Result<Waiting<S, N>, Refusal> {
        let refused = |reason| Refusal::Seek { tag: asked.tag, reason };
        #[cfg(feature = "probe")]
        {
            let probe = asked.probe(&self.end).map_err(refused)?;
            Ok(self.prepare_seek(number, asked.tag, What::Probe(probe, asked.required)))
        }
        #[cfg(not(feature = "probe"))]
        {
            let _ = number;
            Err(refused(SeekRefusal::Unknown))
        }
    }

    /// Homing as it waits.
    #[cfg_attr(not(feature = "home"), allow(clippy::unused_self))]
    pub(super) fn prepare_home(
        &mut self,
        number: u32,
        asked: &HomeMove,
    ) -> Result<Waiting<S, N>, Refusal> {
        let refused = |reason| Refusal::Seek { tag: asked.tag, reason };
        #[cfg(feature = "home")]
        {
            let home = asked.home().map_err(refused)?;
            Ok(self.prepare_seek(number, asked.tag, What::Home(home)))
        }
        #[cfg(not(feature = "home"))]
        {
            let _ = number;
            Err(refused(SeekRefusal::Unknown))
        }
    }

    /// What is first in the queue is to be sought: begins when everything before it has been run.
    #[cfg(feature = "probe")]
    pub(super) fn begin_seek<const BLOCKS: usize, const NODES: usize>(
        &mut self,
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
    ) {
        let Some(seek) = self.seeking.seek.as_mut().filter(|seek| !seek.begun) else { return };
        // No more blocks come before it.
        planner.finish();
        let begun = match &seek.what {
            What::Probe(probe, _) => planner.probe(probe),
            #[cfg(feature = "home")]
            What::Home(axes) => planner.home(axes),
        };
        match begun {
            Ok(()) => {
                seek.begun = true;
                #[cfg(feature = "home")]
                if let What::Home(_) = seek.what {
                    let (number, tag) = (seek.number, seek.tag);
                    let steps = [HomeStep::Waits; N];
                    self.seeking.homed =
                        Some(Homed { number, tag, over: false, steps, fault: None });
                }
            }
            Err(error) => self.refuse_seek(&error),
        }
    }

    #[cfg(not(feature = "probe"))]
    #[allow(clippy::unused_self)]
    pub(super) const fn begin_seek<const BLOCKS: usize, const NODES: usize>(
        &mut self,
        _: &mut Planner<'_, S, N, BLOCKS, NODES>,
    ) {
    }

    /// It cannot begin: not now, or never.
    #[cfg(feature = "probe")]
    fn refuse_seek(&mut self, error: &ProbeError) {
        let Some(reason) = SeekRefusal::of(error) else { return };
        let tag = self.seeking.seek.map_or(0, |seek| seek.tag);
        self.seeking.seek = None;
        self.queue.clear();
        self.refuse(Refusal::Seek { tag, reason });
    }

    /// Hears what has come of what is sought.
    #[cfg(feature = "probe")]
    pub(super) fn note_sought<const BLOCKS: usize, const NODES: usize>(
        &mut self,
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
    ) {
        let Some(seek) = self.seeking.seek.filter(|seek| seek.begun) else { return };
        #[cfg(feature = "home")]
        if let Some(homed) = self.seeking.homed.as_mut().filter(|homed| !homed.over) {
            homed.steps = core::array::from_fn(|axis| planner.home_phase(axis).into());
        }
        if planner.is_jogging() {
            return;
        }
        let refusal = match seek.what {
            What::Probe(_, required) => {
                let Some(probed) = planner.probed() else { return };
                let result = ProbeResult::new(seek.number, seek.tag, &probed);
                self.seeking.probed = Some((seek.number, seek.tag, probed));
                let found = match probed.outcome {
                    Outcome::Tripped => true,
                    Outcome::Missed => !required,
                    Outcome::Cancelled => false,
                };
                (!found).then_some(Refusal::Probe { tag: seek.tag, end: result.end })
            }
            #[cfg(feature = "home")]
            What::Home(_) => {
                let Some(result) = planner.homed() else { return };
                if let Some(homed) = &mut self.seeking.homed {
                    (homed.over, homed.fault) = (true, result.err());
                }
                result.is_err().then_some(Refusal::Home { tag: seek.tag })
            }
        };
        self.seeking.seek = None;
        if let Some(Waiting::Seek) = self.queue.front() {
            self.queue.pop_front();
        }
        self.end = *planner.end();
        (self.due.status, self.due.taken) = (true, true);
        if let Some(refusal) = refusal
            && !self.aborting
        {
            self.no_more(refusal);
        }
    }

    #[cfg(not(feature = "probe"))]
    #[allow(clippy::unused_self)]
    pub(super) const fn note_sought<const BLOCKS: usize, const NODES: usize>(
        &mut self,
        _: &mut Planner<'_, S, N, BLOCKS, NODES>,
    ) {
    }
}
