//! The protocol of grbl: the background of a controller that speaks it.

use core::hint::black_box;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use splineway::grbl::{Accessories, Event, Events, Inputs, Settings, Store};
use splineway::{Config, Planner, Setpoint};
use splineway_controller::grbl::{Background, Port};

static EVENTS: Events<8> = Events::new();
static WORD: AtomicU32 = AtomicU32::new(0);

/// Pages, as far as a compiler can know.
struct Pages;

impl Store for Pages {
    fn read(&mut self, copy: usize, at: usize) -> Option<u32> {
        black_box((copy, at));
        black_box(Some(WORD.load(Relaxed)))
    }
    fn erase(&mut self, copy: usize) -> bool {
        black_box(copy) == 0
    }
    fn write(&mut self, copy: usize, at: usize, word: u32) -> bool {
        WORD.store(word, Relaxed);
        black_box(copy) > black_box(at)
    }
}

/// A board, as far as a compiler can know.
struct Board<'a>(&'a Setpoint<f32, 3>, Pages);

impl Port<f32, 3> for Board<'_> {
    type Store = Pages;

    fn read(&mut self) -> Option<u8> {
        black_box(None)
    }
    fn write(&mut self, byte: u8) -> bool {
        black_box(byte) != 0
    }
    fn setpoint(&mut self) -> Setpoint<f32, 3> {
        *self.0
    }
    fn store(&mut self) -> &mut Pages {
        &mut self.1
    }
    fn inputs(&mut self) -> Inputs {
        black_box(Inputs::default())
    }
    fn switch(&mut self, accessories: &Accessories) {
        black_box(accessories);
    }
    fn power(&mut self) -> f32 {
        black_box(0.0)
    }
    fn happen(&mut self, event: &Event) {
        black_box(event);
    }
    fn apply(&mut self, settings: &Settings<3>) {
        black_box((settings.value(black_box(0)), settings.axes));
    }
}

/// The background of a controller.
pub fn background(
    planner: &mut Planner<'_, f32, 3, 16, 64>,
    setpoint: &Setpoint<f32, 3>,
    config: &Config<f32, 3>,
) {
    let settings = Settings::new(config, black_box([250.0; 3]), black_box([300.0; 3]));
    let mut board = Board(setpoint, Pages);
    let mut background = Background::<_, 3, 16, 64, 8>::new(planner, &EVENTS, settings);
    loop {
        black_box(background.round(&mut board));
        black_box((background.state(), background.settings().axes));
        if black_box(EVENTS.take(setpoint)).is_some() {
            return;
        }
    }
}
