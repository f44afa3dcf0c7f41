//! Homing: `$H`, from the line to its answer (feature `home`).

use super::code::{Alarm, Error};
use super::station::{Doing, Lock, Station};
use crate::gcode::LETTERS;
use crate::jog::HomeFault;
use crate::number::{Coord, Scalar};
use crate::planner::Planner;

impl<S: Scalar, const N: usize> Station<S, N> {
    /// Homes all axes that have a switch, or the one that is named. The answer comes when they are.
    pub(super) fn begin_homing<const BLOCKS: usize, const NODES: usize>(
        &mut self,
        name: &[u8],
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
    ) -> Result<(), Error> {
        let settings = &self.memory.settings;
        if !settings.homing() {
            return Err(Error::HomingDisabled);
        }
        if self.is_door_open() {
            return Err(Error::Door);
        }
        if self.must_stop() {
            return Err(Error::Locked);
        }
        let only = match name {
            [] => None,
            [letter] => {
                let mut letters = LETTERS.iter().take(N);
                let axis = letters.position(|own| *own == char::from(*letter));
                Some(axis.ok_or(Error::Statement)?)
            }
            _ => return Err(Error::Statement),
        };
        let homes = settings.homes(only);
        if homes.iter().all(Option::is_none) {
            return Err(Error::HomingDisabled);
        }
        planner.home(&homes).map_err(|error| Error::of_homing(&error))?;
        self.lock = Lock::Open;
        self.doing = Doing::Homing { all: only.is_none() };
        Ok(())
    }

    /// Waits for the axes. Whether more could be done at once.
    pub(super) fn go_on_homing<const BLOCKS: usize, const NODES: usize>(
        &mut self,
        all: bool,
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
    ) -> bool {
        if planner.is_jogging() {
            return false;
        }
        let Some(homed) = planner.homed() else { return false };
        if let Err(failure) = homed {
            self.alarm(
                match failure.fault {
                    HomeFault::Missing => Alarm::HomingApproach,
                    HomeFault::Stuck => Alarm::HomingPullOff,
                    // By another context than this line's.
                    HomeFault::Cancelled => Alarm::HomingReset,
                },
                planner.controls(),
            );
            return false;
        }
        self.reader.stand_at(planner.end());
        // In coordinates that are no more.
        self.probed = ([Coord::ZERO; N], false);
        self.doing = Doing::Nothing;
        self.answer(Ok(()));
        if all {
            self.startup = Some(0);
        }
        true
    }
}
