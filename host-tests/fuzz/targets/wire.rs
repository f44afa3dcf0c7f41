//! Any bytes on the line, at either end: nothing panics, and what is taken can be planned.
#![no_main]

use libfuzzer_sys::fuzz_target;
use splineway::wire::{FRAME, Inlet, Reply, Request, Sender, Situation, Station, encode};
use splineway::{AxisLimits, Config, Coord, Limits, Link, Planner};

fuzz_target!(|data: &[u8]| {
    let axis = AxisLimits { velocity: 200.0, acceleration: 2000.0, jerk: 50_000.0, rotary: false };
    let Ok(limits) = Limits::new([axis; 3]) else { return };
    let mut link = Box::new(Link::<f32, 3, 48>::new());
    let Ok((mut planner, mut interpolator)) = link.handles::<8>(Config::new(limits), [Coord::ZERO; 3])
    else {
        return;
    };
    let _: &Planner<'_, f32, 3, 8, 48> = &planner;
    let mut station = Station::<f32, 3, 8>::new();
    let (mut inlet, mut sender) = (Inlet::new(), Sender::new(7, 100));
    let mut out = [0; FRAME];
    let mut step = |station: &mut Station<f32, 3, 8>, byte: u8| {
        if let Some(command) = station.receive(byte) {
            command.send(planner.controls());
        }
        if byte == 0 {
            station.feed(&mut planner);
            planner.poll();
            interpolator.tick();
            let _ = station.reply(Situation::default, &mut out);
        }
    };
    for (now, &byte) in (0..).zip(data) {
        step(&mut station, byte);
        if let Some(reply) = inlet.push::<Reply>(byte) {
            sender.hear(&reply, now);
        }
        let _ = sender.step(now);
    }
    // What is well formed gets through, whatever came before.
    let mut frame = [0; FRAME];
    let length = encode(&Request::Open { session: 9 }, &mut frame).unwrap_or(0);
    step(&mut station, 0);
    for &byte in &frame[..length] {
        step(&mut station, byte);
    }
    assert_eq!(station.taken(), 0);
});
