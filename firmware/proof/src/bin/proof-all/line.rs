//! The wire: both ends of it.

use core::hint::black_box;
use splineway::wire::{
    Command, Event, Events, FRAME, Inlet, Item, Move, Path, Refusal, Reply, Request, Sender, Speed,
    Station, Step, Target, encode,
};
use splineway::{Block, Controls, Coord, Planner, Setpoint};
use splineway_controller::{Background, Clock, Port};

/// Kept by a controller.
static EVENTS: Events<8> = Events::new();

/// The controller's end.
pub fn controller(planner: &mut Planner<'_, f32, 3>, setpoint: &Setpoint<f32, 3>) -> Option<Event> {
    let mut station = black_box(Station::<f32, 3, 16>::new());
    let mut frame = black_box([0; FRAME]);
    for byte in black_box([1; 8]) {
        if let Some(command) = station.receive(black_box(byte)) {
            command.send(planner.controls());
        }
    }
    station.close(black_box(Refusal::Alarm));
    black_box(station.poll(planner, &EVENTS, black_box(1)));
    black_box((station.taken(), station.is_full(), station.is_waiting(), station.state(setpoint)));
    black_box(station.reply(setpoint, &mut frame));
    black_box(frame);
    black_box(EVENTS.happened());
    EVENTS.take(setpoint)
}

/// A board, as far as a compiler can know.
struct Board<'a>(&'a Setpoint<f32, 3>, Clock);

impl Port<f32, 3> for Board<'_> {
    fn read(&mut self) -> Option<u8> {
        black_box(None)
    }
    fn write(&mut self, byte: u8) -> bool {
        black_box(byte) != 0
    }
    fn now_ms(&mut self) -> u32 {
        self.1.ms(black_box(1))
    }
    fn setpoint(&mut self) -> Setpoint<f32, 3> {
        *self.0
    }
    fn alarm(&mut self) -> bool {
        black_box(false)
    }
}

/// The background of a controller.
pub fn background(planner: &mut Planner<'_, f32, 3, 16, 64>, setpoint: &Setpoint<f32, 3>) {
    let mut board = Board(setpoint, Clock::new(black_box(10)));
    let mut background = Background::<_, 3, 16, 64, 16, 8>::new(planner, &EVENTS);
    black_box(background.round(&mut board));
    black_box((background.state(setpoint), background.is_done(setpoint)));
    black_box((background.is_full(), background.taken()));
}

/// The host's end, which may be a board too.
pub fn host(controls: Controls<'_>) -> Option<()> {
    let mut sender = black_box(Sender::new(black_box(1), black_box(1), black_box(100)).aborting());
    sender.set_items(black_box(2));
    black_box((sender.is_open(), sender.denied(), sender.taken(), sender.refused()));
    black_box((sender.is_done(), sender.command(black_box(Command::Hold))));
    sender.abort();
    black_box(Command::Hold).send(controls);
    let mut frame = black_box([0; FRAME]);
    black_box(encode(&sender.farewell(), black_box(&mut frame)))?;
    let request = match sender.step(black_box(1)) {
        Step::Item(number) => sender.item(number, black_box(item()?)),
        Step::Send(request) => request,
        Step::Wait => return None,
    };
    black_box(encode(&request, black_box(frame.get_mut(..black_box(9))?))?);
    let mut inlet = black_box(Inlet::new());
    for byte in black_box(frame) {
        if let Some(reply) = inlet.push::<Reply>(byte) {
            sender.hear(&reply, black_box(1));
        }
        black_box(inlet.push::<Request>(byte));
    }
    black_box(inlet.damaged());
    Some(())
}

/// A block as an item.
fn item() -> Option<Item> {
    if black_box(false) {
        return Some(Item::End);
    }
    let block: Block<f32, 3> = black_box(Block::line([Coord::ZERO; 3], 1.0, 1));
    let mut step = black_box(Move::from(&block));
    let to: Target = black_box([Some(1); 3]).into_iter().collect();
    (step.path, step.speed) = black_box((Path::Line { to }, Speed::Rapid));
    black_box(step.block::<f32, 3>(&black_box([Coord::ZERO; 3])).ok()?);
    Some(Item::Move(step))
}
