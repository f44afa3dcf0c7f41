//! An operator who presses anything at any time.

use splineway_simulator::run::{Action, Command, Event, Events};

/// One command: when (as a share of the time), which, how much.
pub type Press = (f64, u8, u16);

/// Commands at random times, and at last everything that lets the program run to its end.
pub fn events(commands: &[Press], time: f64) -> Events {
    let mut list: Vec<Event> = commands
        .iter()
        .map(|&(when, kind, percent)| {
            let action = match kind {
                0..=2 => Action::Command(Command::Hold),
                3 => Action::Command(Command::QuickHold),
                4..=6 => Action::Command(Command::Resume),
                7 => Action::Command(Command::Stop),
                8 => Action::Command(Command::SingleBlock(true)),
                9 => Action::Command(Command::SingleBlock(false)),
                10 => Action::Command(Command::RapidOverride(percent.min(100))),
                11 => Action::Starve(f64::from(percent) * 1.0e-3),
                12 if percent < 20 => Action::Command(Command::QuickAbort),
                12 if percent < 40 => Action::Command(Command::Abort),
                _ => Action::Command(Command::FeedOverride(percent)),
            };
            Event { time: when * time, action }
        })
        .collect();
    let end = time + 0.3;
    list.push(Event { time: end, action: Action::Command(Command::SingleBlock(false)) });
    list.push(Event { time: end, action: Action::Command(Command::FeedOverride(150)) });
    list.push(Event { time: end, action: Action::Command(Command::RapidOverride(100)) });
    list.push(Event { time: end, action: Action::Command(Command::Resume) });
    // A stop that was asked for may only have come to its block's end now.
    list.push(Event { time: end + 3.0, action: Action::Command(Command::Resume) });
    Events::new(list)
}
