//! What the planner is doing: one value, with data only where it exists.
//!
//! ```text
//!                  start                     taken
//!    ┌─ Resting ─────────────▶ Offered ──────────────────▶ Following ─┐
//!    │     ▲                    │    ▲                       │   │    │
//!    │     │ withdrawn (start)  │    │ plan on, or answer    │   │    │ a command is answered
//!    │     ├────────────────────┤    └───────────────────────┘   │    │ without a new plan
//!    │     │                    │ refused, withdrawn             │    │
//!    │     │                    └───────────────────────────────▶│◀───┘
//!    │     │ at the end of the plan                              │
//!    │     └─────────────────────────────────────────────────────┘
//!    └─ Ready ──▶ AwaitsResume ──▶ Ready; any ──▶ Dropped ──▶ Ready
//! ```
//!
//! | from | to | by | when |
//! |---|---|---|---|
//! | `Resting` | `Offered` | `Planner::offer`, from `poll_at_rest` | blocks are planned from the rest on |
//! | `Following` | `Offered` | `Planner::offer`, from `poll_moving` | a part of the plan has been run, or its end is near |
//! | `Following` | `Offered` | `Planner::offer`, from [`command`](super::command) | a command is answered by a plan |
//! | `Following` | `Following` | [`Following::go_on`], [`Following::rest_at_end`] | a halt is called off, or the plan ends where it is wanted |
//! | `Offered` | `Following` | `Planner::hear` | the interrupt has taken the plan |
//! | `Offered` | `Following`, `Resting` | `Planner::hear`, `revoke` | it has refused the plan, or the planner has withdrawn it: back to what was before |
//! | `Following` | `Resting` | `Planner::obey_at_rest` | the motion is at the end of the plan |
//! | `Ready` | `AwaitsResume` | `Planner::obey_at_rest` | the rest is a pause, or the end of a block in single block mode |
//! | `AwaitsResume` | `Ready` | `Planner::obey_at_rest` | a resume |
//! | any rest | `Dropped` | `Planner::drop_all` | an abort |
//! | `Dropped` | `Ready` | `Planner::acknowledge_abort` | the producer knows |
//!
//! Before a plan is offered it is in the making ([`super::making`]), in `Resting` or `Following`: the horizon has a draft
//! then, and in [`Phase::Offered`], and at no other time.

use crate::number::serial::{CycleSerial, NodeSerial};
use crate::servo::control::Wish;

/// Why the plan ends where it does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Halt {
    /// As soon as the limits allow.
    Hold,
    /// Wherever: the motion slows down to rest as soon as the limits allow, and the next stage of that follows.
    Slowing,
    /// At the end of a block.
    Block,
    /// As soon as the limits allow, and from there to the end of the block: one further on would be too far.
    Short,
}

impl Halt {
    /// Whether it is still asked for; `short`: for a stop, too, the motion is to come to rest as soon as it can.
    pub fn is_wanted(self, wish: &Wish, short: bool) -> bool {
        match self {
            Self::Hold => wish.holds(),
            Self::Slowing => wish.holds() || (short && wish.stops_at_end()),
            Self::Block | Self::Short => wish.stops_at_end(),
        }
    }
}

/// What the planner is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// The motion is at the end of the agreed plan.
    Resting(Rest),
    /// The agreed plan is being run.
    Following(Following),
    /// A plan has been offered, and the interrupt has yet to decide on it. Until then it follows the one before, or
    /// rests.
    Offered(Offer),
}

/// What a rest waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rest {
    /// Blocks; servo cycle since which it has had some, and waits for more.
    Ready { since: Option<CycleSerial> },
    /// A resume: it is a pause, or the end of a block in single block mode.
    AwaitsResume,
    /// The producer's word: everything has been dropped for the abort with this number.
    Dropped { abort: u32 },
}

impl Rest {
    /// With nothing to do.
    pub const IDLE: Self = Self::Ready { since: None };
}

/// A plan that is being run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Following {
    /// Why it ends where it does, if an operator has asked for it.
    pub halt: Option<Halt>,
    /// Node from which on it is time for a new plan.
    pub checkpoint: NodeSerial,
    /// Node from which on the motion shows that the plan ends at rest: another should have taken over by then.
    pub shown: NodeSerial,
    /// Whether a rest at the end of a block has been looked for in it, in vain.
    pub tried_block_end: bool,
}

impl Following {
    /// The halt is called off: on at once.
    pub fn go_on(&mut self, at: NodeSerial) {
        self.halt = None;
        self.checkpoint = at;
    }

    /// The plan ends where the motion is to rest.
    pub fn rest_at_end(&mut self, halt: Halt) {
        self.halt = Some(halt);
    }
}

/// A plan on offer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Offer {
    /// Node from which it starts.
    pub first: NodeSerial,
    /// Node at which it ends.
    pub end: NodeSerial,
    /// Whether it branches off at a servo cycle.
    pub by_cycle: bool,
    /// Whether it is a first answer to overrides, or one that falls short, behind which another branches off.
    pub begins: bool,
    /// What will be if it is taken.
    pub taken: Following,
    /// What was before, and will be again if it is refused; `None` at rest.
    pub before: Option<Following>,
}

impl Offer {
    /// What comes after it has been refused or withdrawn: what was before, and the next plan is due as it was.
    pub fn refused(&self) -> Phase {
        match self.before {
            None => Phase::Resting(Rest::IDLE),
            Some(before) => Phase::Following(Following { tried_block_end: false, ..before }),
        }
    }
}

impl Phase {
    /// Why the newest plan ends where it does, if an operator has asked for it.
    pub fn halt(&self) -> Option<Halt> {
        match self {
            Self::Resting(_) => None,
            Self::Following(now) => now.halt,
            Self::Offered(offer) => offer.taken.halt,
        }
    }

    /// The plan on offer, if there is one.
    pub fn offer(&self) -> Option<&Offer> {
        if let Self::Offered(offer) = self { Some(offer) } else { None }
    }
}
