//! Any bytes on the line, at either end: nothing panics, and what is taken can be planned.
#![no_main]

use libfuzzer_sys::fuzz_target;
use splineway::wire::{Events, FRAME, Inlet, Reply, Request, Sender, Station, encode};
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
    let (mut inlet, mut sender) = (Inlet::new(), Sender::new(7, 100, 1000));
    let mut out = [0; FRAME];
    let events = Events::<4>::new();
    let mut ms = 0;
    let mut answers = Inlet::new();
    let mut step = |station: &mut Station<f32, 3, 8>, byte: u8| {
        if let Some(command) = station.receive(byte) {
            command.send(planner.controls());
        }
        if byte == 0 {
            station.poll(&mut planner, &events, ms);
            ms += 1;
            let setpoint = interpolator.tick();
            let _ = events.take(&setpoint);
            let length = station.reply(&setpoint, &mut out);
            return out[..length].iter().filter_map(|&byte| answers.push::<Reply>(byte)).last();
        }
        None
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
    let length = encode(&Request::Hello { session: 9 }, &mut frame).unwrap_or(0);
    step(&mut station, 0);
    let answer = frame[..length].iter().filter_map(|&byte| step(&mut station, byte)).last();
    assert!(matches!(answer, Some(Reply::Hello { .. })));
});
