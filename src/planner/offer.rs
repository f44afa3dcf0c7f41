//! Plans handed over to the interrupt, and its word on them.

use super::Planner;
use super::horizon::{Moment, Proposal};
use super::phase::{Following, Halt, Offer, Phase};
use crate::number::Scalar;

/// New plans are asked for when this part of the present one has been run, and no more than this
/// many cells of it are left: enough that its stop at the end does not show in what is run.
const PLAN_PART: u32 = 2;
const CELLS_LEFT: u32 = 64;

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'_, S, N, BLOCKS, NODES>
{
    /// Where the motion is, and when an answer can take effect; `None` if the interrupt is changing over.
    pub(super) fn moment(&self) -> Option<Moment<S>> {
        let timeline = self.side.timeline()?;
        Some(Moment { timeline, when: self.side.cycles().plus(self.reaction) })
    }

    /// Offers a draft, whose pieces have been written, to the interrupt.
    pub(super) fn offer(&mut self, Proposal { stretch, branch, halt }: Proposal) {
        let before = match self.phase {
            Phase::Resting(_) => None,
            Phase::Following(now) => Some(now),
            Phase::Offered(_) => {
                debug_assert!(false, "one offer at a time");
                return;
            }
        };
        self.horizon.mark_offered();
        #[cfg(feature = "outputs")]
        self.time_switches(branch);
        self.side.offer(branch);
        let window = &self.horizon.window;
        let (first, end) = (window.serial(stretch.first), window.serial(stretch.last));
        let cells = end.since(first).unwrap_or(0);
        let run = (cells / PLAN_PART).max(cells.saturating_sub(CELLS_LEFT)).max(1);
        let by_cycle = branch.is_by_cycle();
        let checkpoint = first.plus(run);
        let taken = Following { halt, checkpoint, shown: end, tried_block_end: false };
        self.phase = Phase::Offered(Offer { first, end, by_cycle, begins: false, taken, before });
        self.counters.plans += 1;
        #[cfg(feature = "defmt")]
        defmt::debug!(
            "plan {}: nodes {} to {}, {} steps so far",
            self.counters.plans,
            first.raw(),
            end.raw(),
            self.horizon.steps
        );
    }

    /// The interrupt's word on the plan on offer.
    #[inline(never)]
    pub(super) fn hear(&mut self) {
        let Phase::Offered(offer) = self.phase else { return };
        if self.decided(&offer) == Some(false) {
            #[cfg(feature = "defmt")]
            defmt::warn!("the plan from node {} came too late", offer.first.raw());
            if offer.taken.halt != Some(Halt::Hold) {
                (self.pressing.reacted, self.pressing.eased) = (None, None);
            }
            if offer.taken.halt == Some(Halt::Block) {
                self.pressing.short = true;
            }
            self.late(offer.by_cycle);
        }
    }

    /// The motion has been too fast for a plan: an answer to a command is given more time next. (What others take is measured.)
    pub(super) fn late(&mut self, by_cycle: bool) {
        self.counters.late += 1;
        if by_cycle {
            self.reaction = (2 * self.reaction + 1).min(self.most_reaction());
        }
    }

    /// Takes back a plan that has not been decided on, unless it will be within so many servo cycles. Whether there is none any more.
    #[inline(never)]
    pub(super) fn revoke(&mut self, soon: u32) -> bool {
        let Phase::Offered(offer) = self.phase else { return true };
        // Where planning takes long, one may be ready long before the servo cycle at which it branches off.
        if offer.by_cycle && self.side.undecided_for() <= soon {
            return false;
        }
        self.side.withdraw();
        self.decided(&offer).is_some()
    }

    /// Commits or drops the draft on offer, as it was decided; `None` if it has not been.
    fn decided(&mut self, offer: &Offer) -> Option<bool> {
        let taken = self.side.verdict()?;
        #[cfg(feature = "reshape")]
        self.reshaping(|planner, memory| planner.decide_reshaped(memory, taken));
        if taken {
            self.horizon.commit(offer.first, offer.end);
            let first = self.horizon.window.clamped_index(offer.first);
            let shown = self.horizon.shown_from(first);
            self.phase = Phase::Following(Following { shown, ..offer.taken });
            // From a rest within a block the motion goes on as any other: if its end is not known yet, that is looked for in motion.
            self.pressing.short &= offer.before.is_some();
        } else {
            self.horizon.drop_draft();
            self.phase = offer.refused();
        }
        Some(taken)
    }

    /// Servo cycles in a lead.
    #[inline(never)]
    pub(super) fn most_reaction(&self) -> u32 {
        let config = &self.horizon.config;
        (config.lead / config.cycle).to_i64().clamp(1, 1_000_000) as u32
    }
}
