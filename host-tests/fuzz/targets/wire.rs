//! Any bytes on the line, at either end, and any bytes within whole frames: nothing panics, and what is taken can be
//! planned.
#![no_main]

use libfuzzer_sys::fuzz_target;
use serde::ser::{Serialize, SerializeTuple, Serializer};
use splineway::wire::{Events, FRAME, Inlet, Reply, Request, Sender, Station, encode};
use splineway::{AxisLimits, Config, Coord, Interpolator, Limits, Link, Planner, Progress, Setpoint};

/// Bytes that are written as they are: what comes behind a CRC that fits.
struct Raw<'a>(&'a [u8]);

impl Serialize for Raw<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut tuple = serializer.serialize_tuple(self.0.len())?;
        for byte in self.0 {
            tuple.serialize_element(byte)?;
        }
        tuple.end()
    }
}

struct Rig<'a> {
    planner: Planner<'a, f32, 3, 8, 48>,
    interpolator: Interpolator<'a, f32, 3>,
    setpoint: Setpoint<f32, 3>,
    station: Station<f32, 3, 8>,
    events: Events<4>,
    answers: Inlet,
    inlet: Inlet,
    sender: Sender,
    ms: u32,
}

impl Rig<'_> {
    /// A byte on the line in both directions; after a zero a servo cycle. What the controller answers.
    fn byte(&mut self, byte: u8) -> Option<Reply> {
        let now = u64::from(self.ms);
        if let Some(reply) = self.inlet.push::<Reply>(byte) {
            self.sender.hear(&reply, now);
        }
        let _ = self.sender.step(now);
        if let Some(command) = self.station.receive(byte) {
            command.send(self.planner.controls());
        }
        if byte == 0 { self.cycle() } else { None }
    }

    fn cycle(&mut self) -> Option<Reply> {
        self.ms += 1;
        while self.station.poll(&mut self.planner, &self.events, self.ms) == Progress::Planning {}
        let before = [0, 1, 2].map(|axis| self.setpoint.position(axis).to_mm());
        self.setpoint = self.interpolator.tick();
        let _ = self.events.take(&self.setpoint);
        for (axis, before) in before.into_iter().enumerate() {
            // No axis is faster than 200 mm/s, whatever the line says.
            let after = self.setpoint.position(axis).to_mm();
            assert!((after - before).abs() <= 0.2001, "a jump");
        }
        let mut out = [0; FRAME];
        let length = self.station.reply(&self.setpoint, &mut out);
        out[..length].iter().filter_map(|&byte| self.answers.push(byte)).last()
    }

    /// Frames of a length and so many bytes; a length of 224 and more lets time go by.
    fn frames(&mut self, mut data: &[u8]) {
        while let Some((&length, rest)) = data.split_first() {
            if length >= 224 {
                for _ in 0..u32::from(length - 223) * 8 {
                    self.cycle();
                }
                data = rest;
                continue;
            }
            let (payload, rest) = rest.split_at(rest.len().min(usize::from(length)));
            let mut frame = [0; FRAME];
            let length = encode(&Raw(payload), &mut frame).unwrap_or(0);
            for &byte in &frame[..length] {
                self.byte(byte);
            }
            data = rest;
        }
    }
}

fuzz_target!(|data: &[u8]| {
    let axis = AxisLimits::linear(200.0, 2000.0, 50_000.0);
    let Ok(limits) = Limits::new([axis; 3]) else { return };
    let mut link = Box::new(Link::<f32, 3, 8, 48>::new());
    let Ok((planner, mut interpolator)) = link.split(Config::new(limits), [Coord::ZERO; 3])
    else {
        return;
    };
    let setpoint = interpolator.tick();
    let (station, events) = (Station::new(), Events::new());
    let (answers, inlet, sender) = (Inlet::new(), Inlet::new(), Sender::new(7, 100, 1000));
    let mut rig =
        Rig { planner, interpolator, setpoint, station, events, answers, inlet, sender, ms: 0 };
    match data {
        // Framed.
        [b'f', rest @ ..] => rig.frames(rest),
        _ => {
            for &byte in data {
                rig.byte(byte);
            }
        }
    }
    // What is well formed gets through, whatever came before.
    let mut frame = [0; FRAME];
    let length = encode(&Request::Hello { session: 9 }, &mut frame).unwrap_or(0);
    rig.byte(0);
    let answer = frame[..length].iter().filter_map(|&byte| rig.byte(byte)).last();
    assert!(matches!(answer, Some(Reply::Hello { .. })));
});
