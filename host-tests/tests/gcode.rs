//! G-code files: what is read, and as what; what is refused, and where.

use splineway::gcode::{Code, Dialect};
use splineway_simulator::machine::Machine;
use splineway_simulator::program::{
    AXES, Course, Finding, Move, Point, Program, ReadOptions, Setup, Speed, gcode, inspect_bytes,
};
use splineway_simulator::run::{Precision, run, validate};
use std::fmt::Write;
use std::path::Path;

fn examine(text: &str, options: ReadOptions<'_>) -> (Program, Vec<Finding>) {
    gcode::examine(text.as_bytes(), options)
}

fn options(dialect: Dialect) -> ReadOptions<'static> {
    ReadOptions { dialect: Some(dialect), ..ReadOptions::DEFAULT }
}

const MILL: Dialect = Dialect::LinuxCnc;

fn errors(text: &str, dialect: Dialect) -> Vec<String> {
    let (_, findings) = examine(text, options(dialect));
    findings.iter().filter(|finding| finding.is_error()).map(ToString::to_string).collect()
}

/// A program that must be fine.
fn read(text: &str, dialect: Dialect) -> Program {
    let (program, findings) = examine(text, options(dialect));
    let errors: Vec<_> = findings.iter().filter(|finding| finding.is_error()).collect();
    assert!(errors.is_empty(), "{text:?}: {errors:?}");
    program
}

/// What a program does, in short: where its moves end (X Y Z as far as they are not 0), F as feed, and its events.
fn story(program: &Program) -> String {
    let place = |to: &Point| {
        let mut text = String::new();
        for (letter, value) in ["X", "Y", "Z", "A", "B", "C", "U", "V", "W"].iter().zip(to) {
            let value = (value * 1e9).round() / 1e9;
            if value != 0.0 {
                write!(text, "{letter}{value}").unwrap();
            }
        }
        if text.is_empty() { "0".to_owned() } else { text }
    };
    let mut parts = Vec::new();
    for step in &program.moves {
        let speed = match step.speed {
            Speed::Rapid => "G0 ".to_owned(),
            Speed::PerSecond(feed) => format!("F{} ", (feed * 1e6).round() / 1e6),
            Speed::Duration(seconds) => format!("T{seconds} "),
        };
        parts.push(match &step.path {
            Course::Line { to } => format!("{speed}{}", place(to)),
            Course::Arc { to, centre, clockwise, extra_turns, .. } => {
                let sense = if *clockwise { "cw" } else { "ccw" };
                let (x, y) = ((centre.0 * 1e9).round() / 1e9, (centre.1 * 1e9).round() / 1e9);
                format!("{sense}({} {})+{extra_turns} {}", x + 0.0, y + 0.0, place(to))
            }
            Course::Cubic { to, .. } => format!("cubic {}", place(to)),
            Course::Dwell { seconds } => format!("dwell {seconds}"),
            Course::Event { code, value, pause } => {
                let value = value.map_or(String::new(), |value| format!(":{value}"));
                format!("{code}{value}{}", if *pause { "!" } else { "" })
            }
        });
    }
    parts.join(", ")
}

/// What follows a probe depends on the machine: a program that is read before it runs has none.
#[test]
fn a_probe_in_a_program_is_refused_by_line() {
    for line in ["G31 Z-10", "G38.2 Z-10", "G38.3 Z-10 F100", "G38.5 X2"] {
        let found = errors(&format!("G21 G90 G1 X1 Y1 Z1 F600\n{line}\nG1 X1"), MILL);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].starts_with("line 2: a probe within a program"), "{found:?}");
    }
    let found = errors("G38.2 F100\n", MILL);
    assert!(found[0].contains("G38.2 needs axis words"), "{found:?}");
}

/// Every line of these was once a move, or changed where moves go without a word.
#[test]
#[allow(clippy::too_many_lines)]
fn words_of_codes_that_do_not_move_never_move() {
    let before = "G21 G90 G1 X1 Y1 Z1 F600\n";
    for (line, part) in [
        ("M201 X500 Y500 Z100", "M201"),
        ("m201x500y500z100", "M201"),
        ("Y500 M201 X500", "M201"),
        ("N5 M203 X500 Y500 Z10 E60", "M203"),
        ("M205 X10 Y10", "M205"),
        ("M92 X80", "M92"),
        ("M600 X50 Y50", "M600"),
        ("G33 Z-10 K1", "G33"),
        ("G33.1 Z-10 K1", "G33.1"),
        ("G76 P1 Z-10 I1 J1 R1 K1", "G76"),
        ("G29 X10 Y20", "G29"),
        ("G49 Z5", "column 5: no code of this line takes the word Z"),
        ("G5.3", "G5.3"),
        ("G41 D1 X5", "G41 (tool radius compensation)"),
        ("G42 X5", "G42 (tool radius compensation)"),
        ("G41", "G41"),
        ("G41.1 D5", "G41.1"),
        ("G43 H1 Z5", "tool 1"),
        ("G43", "G43 needs an H word"),
        ("G43.2 H1", "G43.2"),
        ("G51 X1 Y1 P2", "G51 (scaling"),
        ("G16", "G16"),
        ("G96 S200", "G96"),
        ("G70", "G70"),
        ("G71", "G71"),
        ("G95", "G95"),
        ("G7", "G7"),
        ("G55", "G55 has not been set"),
        ("G59.3", "G59.3 has not been set"),
        ("G54.1 P1", "G54.1 is not known"),
        ("G65 P1000 X5", "G65"),
        ("G68.2 X1 Y1", "G68.2"),
        ("M97 P10", "M97"),
        ("M66 P0 L1 Q5", "M66"),
        ("M67 E0 Q1", "M67"),
        ("M70", "M70"),
        ("M110 X5", "M110"),
        ("M150 X5 Y5", "M150"),
        ("M123", "M123"),
        ("M1000 X1", "M1000 is not known"),
        ("G123 X1", "G123 is not known"),
        ("G4 X2", "G4 needs a P word"),
        ("G4 P1 X2", "column 7: no code of this line takes the word X"),
        ("G10 L2 P1", "G10 needs an axis word"),
        ("G10 L2 P12 X1", "P12: it must be a whole number from 0 to 9"),
        ("G10 L1 P1 Z5", "G10 is known with L2 and L20 only"),
        ("G10 L2 P1 X5 R30", "R30"),
        ("G10 P1 X5", "G10 needs an L word"),
        ("G92", "G92 needs an axis word"),
        ("G52", "G52 needs an axis word"),
        ("G0 G92 X5", "G92 and G0 both take this word"),
        ("G1 G28 Z5", "G28 and G1 both take this word"),
        ("G53 G92 X5", "both"),
        ("G28.1 X5", "G28.1 keeps the place"),
        ("X5 Q1", "column 4: no code of this line takes the word Q"),
        ("X5 H1", "no code of this line takes the word H"),
        ("X5 D1", "word D"),
        ("X5 I1", "word I"),
        ("G2 X5 I1 K1", "word K"),
        ("L3 X5", "word L"),
        ("X5 E1", "word E"),
        ("M3 S100 P1", "word P"),
        ("G50 X200 Z100", "column 5: no code of this line takes the word X"),
        ("X5 G50", "word X"),
        ("G50 S2000", "word S"),
        ("G92 X0 S2000", "word S"),
        ("G92.1 X0 Y0", "word X"),
        ("G92.2 X5", "word X"),
        ("G92.3 Z5", "word Z"),
        ("G84 X1 Z-5 R1", "G84 (a canned cycle that needs a spindle)"),
        ("G85 X1 Z-5 R1", "G85"),
        ("G89 X1 Z-5 R1 P1", "G89"),
        ("G74 X1", "G74"),
        ("G17.1", "G17.1"),
        ("M98 P1 X5", "word X"),
        ("M6 T1 R5", "word R"),
        ("G40.5", "G40.5 is not known"),
        ("G1.05 X5", "G1.05"),
        ("G-1 X5", "G-1"),
        ("G81 G80 X5 Z-1 R1", "G81 and G80 exclude each other"),
        ("G80 X5", "axis words without a motion code"),
    ] {
        let found = errors(&format!("{before}{line}\nX1"), MILL);
        assert!(!found.is_empty(), "{line} is not refused");
        assert!(
            found[0].starts_with("line 2, column ") && found[0].contains(part),
            "{line}: {found:?}"
        );
        // Nothing of the line is among the moves.
        let (program, _) = examine(&format!("{before}{line}"), options(MILL));
        assert_eq!(program.moves.len(), 1, "{line}");
        // What can be left out, leaves the tool where it is.
        let lenient = ReadOptions { lenient: true, ..options(MILL) };
        let (program, findings) = examine(&format!("{before}{line}"), lenient);
        if findings.iter().all(|finding| !finding.is_error()) {
            let moved = |step: &&Move| step.path.end().is_some();
            assert_eq!(
                program.moves.iter().filter(moved).count(),
                1 + usize::from(line.starts_with("X5")),
                "{line}"
            );
        }
    }
}

/// What a path can carry, it does.
#[test]
fn offsets_and_cycles_lead_where_they_say() {
    for (text, expected) in [
        // Work offsets.
        ("G10 L2 P1 X50\nG0 X1", "G0 X51"),
        ("G10 L2 P2 X50 Y5\nG55 G0 X1\nG54 X1", "G0 X51, G0 X1"),
        ("G10 L2 P0 X7\nG0 X1 Y1", "G0 X8Y1"),
        ("G0 X10\nG10 L20 P1 X0\nG0 X5", "G0 X10, G0 X15"),
        ("G10 L20 P9 X5\nG59.3\nG0 X5", "G0 0"),
        ("G20 G10 L2 P6 X1\nG59 G0 X1", "G0 X50.8"),
        ("G10 L2 P1 A10\nG0 A5", "G0 A15"),
        // Shifts.
        ("G0 X10\nG92 X0\nG0 X5\nG92.1\nG0 X5", "G0 X10, G0 X15, G0 X5"),
        ("G0 X10\nG92 X0\nG92.2\nG0 X5\nG92.3\nG0 X5", "G0 X10, G0 X5, G0 X15"),
        ("G0 X10\nG92 X0\nG92.3\nG0 X5", "G0 X10, G0 X15"),
        // G52 and G92 share what G92.3 brings back.
        ("G52 X10\nG92.2\nG0 X5\nG92.3\nG0 X5", "G0 X5, G0 X15"),
        ("G92 X10\nG92.2\nG52 X3\nG92.2\nG92.3\nG0 X5", "G0 X8"),
        ("G52 X100\nG0 X1\nG52 X0\nG0 X1", "G0 X101, G0 X1"),
        ("G10 L2 P1 X10\nG52 X100\nG0 X1", "G0 X111"),
        ("G10 L2 P1 X10\nG52 X100\nG53 G0 X1", "G0 X1"),
        ("G91\nG53 G0 X5", "G0 X5"),
        // Length of the tool.
        ("G43.1 Z-3\nG0 Z10\nG49\nG0 Z10", "G0 Z7, G0 Z10"),
        ("G20 G43.1 Z1\nG21 G0 Z1", "G0 Z26.4"),
        ("G43 H0 G0 Z5", "G0 Z5"),
        ("G49 G0 Z5", "G0 Z5"),
        // Rotation.
        ("G68 X0 Y0 R90\nG0 X10\nG0 Y5\nG69\nG0 X1", "G0 Y10, G0 X-5Y10, G0 X1Y10"),
        ("G68 X10 Y0 R180\nG0 X12 Y1 Z3", "G0 X8Y-1Z3"),
        ("G68 X0 Y0 R90\nG91\nG0 X10\nG0 X10", "G0 Y10, G0 Y20"),
        ("G0 X5\nG68 R90\nG0 X6", "G0 X5, G0 X5Y1"),
        ("G68 X0 Y0 R90\nG2 X10 Y0 I5 J0 F60", "cw(0 5)+0 Y10"),
        ("G68 X0 Y0 R90\nG90.1 G2 X10 Y0 I5 J0 F60", "cw(0 5)+0 Y10"),
        ("G68 X0 Y0 R90\nG53 G0 X10", "G0 X10"),
        ("G68 X0 Y0 R0\nG0 X1e+0 Y2", "G0 X1Y2"),
        // Reference points.
        ("G0 X5 Y5 Z5\nG28", "G0 X5Y5Z5, G0 0"),
        ("G0 X5 Y5 Z5\nG91 G28 Z0", "G0 X5Y5Z5, G0 X5Y5"),
        ("G0 X5 Y5\nG28 X6", "G0 X5Y5, G0 X6Y5, G0 Y5"),
        ("G0 X5\nG28.1\nG0 X9\nG28 X9", "G0 X5, G0 X9, G0 X5"),
        ("G0 X5 Z2\nG30 Z10", "G0 X5Z2, G0 X5Z10, G0 X5"),
        ("G0 Z7\nG30.1\nG0 Z1\nG30 Z10", "G0 Z7, G0 Z1, G0 Z10, G0 Z7"),
        // Cycles.
        (
            "G0 Z5\nG81 X10 Y10 Z-3 R1 F60",
            "G0 Z5, G0 X10Y10Z5, G0 X10Y10Z1, F1 X10Y10Z-3, G0 X10Y10Z5",
        ),
        (
            "G0 Z5\nG99 G81 X1 Z-3 R1 F60\nX2\nG98 X3\nG80\nG0 X4",
            "G0 Z5, G0 X1Z5, G0 X1Z1, F1 X1Z-3, G0 X1Z1, G0 X2Z1, F1 X2Z-3, G0 X2Z1, \
             G0 X3Z1, F1 X3Z-3, G0 X3Z5, G0 X4Z5",
        ),
        // G98 goes back to the level that the row of cycles began on, whichever began it.
        (
            "G0 Z9\nG99 G81 X1 Z-1 R1 F60\nG98 G82 X2 Z-2 R2 P0\nG0 X3",
            "G0 Z9, G0 X1Z9, G0 X1Z1, F1 X1Z-1, G0 X1Z1, G0 X1Z2, G0 X2Z2, F1 X2Z-2, dwell 0, G0 X2Z9, G0 X3Z9",
        ),
        ("G0 Z-2\nG81 X1 Z-3 R1 F60", "G0 Z-2, G0 Z1, G0 X1Z1, F1 X1Z-3, G0 X1Z1"),
        ("G82 X1 Z-3 R1 P0.5 F60", "G0 Z1, G0 X1Z1, F1 X1Z-3, dwell 0.5, G0 X1Z1"),
        (
            "G83 X1 Z-3 R1 Q2.5 F60",
            "G0 Z1, G0 X1Z1, F1 X1Z-1.5, G0 X1Z1, G0 X1Z-1.246, F1 X1Z-3, G0 X1Z1",
        ),
        // Depths that are not exact in any binary number are one peck.
        ("G81 Z-19.5678 R-9.2625 F60", "G0 Z-9.2625, F1 Z-19.5678, G0 0"),
        ("G82 Z-19.5678 R-9.2625 P1 F60", "G0 Z-9.2625, F1 Z-19.5678, dwell 1, G0 0"),
        ("G83 Z-19.5678 R-9.2625 Q10.3053 F60", "G0 Z-9.2625, F1 Z-19.5678, G0 0"),
        // A row of cycles goes on behind G28, on its own level and with its words.
        (
            "G0 Z5\nG99 G81 X1 Z-1 R1 F60\nG28 X0\nG98 G81 X2\nG80",
            "G0 Z5, G0 X1Z5, G0 X1Z1, F1 X1Z-1, G0 X1Z1, G0 Z1, G0 X2Z1, F1 X2Z-1, G0 X2Z5",
        ),
        ("G73 X1 Z-3 R1 Q2 F60", "G0 Z1, G0 X1Z1, F1 X1Z-1, G0 X1Z-0.746, F1 X1Z-3, G0 X1Z1"),
        (
            "G0 Z5\nG91 G81 X1 Y1 Z-4 R-4 L2 F60",
            "G0 Z5, G0 X1Y1Z5, G0 X1Y1Z1, F1 X1Y1Z-3, G0 X1Y1Z5, G0 X2Y2Z5, G0 X2Y2Z1, F1 X2Y2Z-3, G0 X2Y2Z5",
        ),
        ("G90 G81 X1 Z-1 R1 L2 F60", "G0 Z1, G0 X1Z1, F1 X1Z-1, G0 X1Z1, F1 X1Z-1, G0 X1Z1"),
        ("G18 G81 X1 Z2 Y-3 R1 F60", "G0 Y1, G0 X1Y1Z2, F1 X1Y-3Z2, G0 X1Y1Z2"),
        ("G20 G81 X1 Z-1 R1 F60", "G0 Z25.4, G0 X25.4Z25.4, F25.4 X25.4Z-25.4, G0 X25.4Z25.4"),
        // Subprograms.
        (
            "G0 X1\nM98 P100 L2\nX9\nM30\nO100\nG91 G0 Y1\nG90\nM99\n",
            "G0 X1, G0 X1Y1, G0 X1Y2, G0 X9Y2",
        ),
        ("O1\nM98 P2\nM2\nO2\nM98 P3\nM99\nN1 O0003\nG0 X3\nM99", "G0 X3"),
        // Curves, exact stops and ends.
        ("G5.1 X2 Y0 I1 J1 F60", "cubic X2"),
        ("G0 X1\nM2\nG0 X2 garbage", "G0 X1"),
        ("%\nG0 X1\n%\nG0 X2", "G0 X1"),
        ("O100\nG0 X1\nM30", "G0 X1"),
        // Codes that switch off what is not there.
        ("G8 G15 G40 G49 G50 G69 G80 G94 G97 G54 G64 G0 X1", "G0 X1"),
    ] {
        assert_eq!(story(&read(text, MILL)), expected.replace("             ", ""), "{text}");
    }
}

#[test]
fn what_the_machine_does_comes_in_order_with_the_motion() {
    for (text, expected) in [
        ("M3 S1000\nG0 X1\nM5", "M3:1000, G0 X1, M5"),
        ("S1000\nM3\nG0 X1", "S:1000, M3:1000, G0 X1"),
        ("G1 X1 M3 S1000 F60", "M3:1000, F1 X1"),
        ("G0 X1 M0", "G0 X1, M0!"),
        ("M1", "M1!"),
        ("T2 M6", "M6:2!"),
        ("T2\nG0 X1\nM6", "T:2, G0 X1, M6:2!"),
        ("M6 T3 S500 M4 M8 G0 X1 M60", "M6:3!, M4:500, M8, G0 X1, M60!"),
        ("M7 M8\nM9", "M7, M8, M9"),
        ("G1 X1 S100 F60\nX2 S100\nX3 S200", "S:100, F1 X1, F1 X2, S:200, F1 X3"),
        ("M62 P3\nM48\nM49", "M62:3, M48, M49"),
        ("M19 R90", "M19:90"),
        ("M61 Q4", "M61:4"),
        ("G4 P0.5", "dwell 0.5"),
        ("M30", ""),
    ] {
        assert_eq!(story(&read(text, MILL)), expected, "{text}");
    }
    // And through the core: a pause is ended when it has been seen.
    let program = read("G1 X1 F600\nM3 S100\nX2\nM0\nX3\nM5\nM2", MILL);
    let stats = run(&program, &Machine::default(), Precision::F32, &mut []).unwrap();
    assert_eq!(stats.blocks, 6);
}

#[test]
fn one_code_of_a_group_and_one_word_of_a_letter() {
    for (line, part) in [
        ("G0 G1 X1", "G0 and G1 exclude each other"),
        ("G1 G1 X1", "G1 twice"),
        ("G90 G91 X1", "G90 and G91 exclude each other"),
        ("G91 X1 G90", "G91 and G90"),
        ("G20 G21", "G20 and G21"),
        ("G17 G18", "G17 and G18"),
        ("G54 G55", "G54 and G55"),
        ("G93 G94", "G93 and G94"),
        ("G61 G64", "G61 and G64"),
        ("G4 P1 G92 X1", "G4 and G92"),
        ("G98 G99", "G98 and G99"),
        ("G43 H0 G49", "G43 and G49"),
        ("M3 M4", "M3 and M4"),
        ("M3 M5", "M3 and M5"),
        ("M0 M30", "M0 and M30"),
        ("M7 M9", "M7 and M9"),
        ("M98 P1 M30", "M98 and M30"),
        ("G1 X1 X2", "a second X word"),
        ("G1 X1 x2", "a second X word"),
        ("F1 F2", "a second F word"),
        ("G2 X1 I1 R1 F1", "a radius or a centre"),
        ("G64 P0.1 G2 X1 I1 P2 F1", "a second P word"),
        ("G64 P1 G2 X1 I0.5 F1", "G64 and G2 both take this word"),
    ] {
        let found = errors(&format!("{line}\n"), MILL);
        assert!(found.len() == 1 && found[0].contains(part), "{line}: {found:?}");
    }
}

#[test]
#[allow(clippy::too_many_lines)]
fn numbers_and_lines() {
    for (text, expected) in [
        ("G0 X1e-05", "G0 X0.00001"),
        ("G0 X-1.5e+1", "G0 X-15"),
        ("G0 X2e+2 Y1", "G0 X200Y1"),
        ("g0x1y2z3", "G0 X1Y2Z3"),
        ("G00 X+1.", "G0 X1"),
        ("G 0 X 1 Y -.5", "G0 X1Y-0.5"),
        ("\tG0\tX1\t", "G0 X1"),
        ("N10G0X1", "G0 X1"),
        ("G0 X1\rX2\rX3", "G0 X1, G0 X2, G0 X3"),
        ("G0 X1\r\nX2\n\rX3\r", "G0 X1, G0 X2, G0 X3"),
        ("\u{feff}G0 X1", "G0 X1"),
        ("G0 X1 ; X2", "G0 X1"),
        ("G0 (X2) X1 (X3)", "G0 X1"),
        ("(caf\u{e9}) G0 X1", "G0 X1"),
        ("% (begin)\nG0 X1\n%", "G0 X1"),
        ("\n\n%\nG0 X1", "G0 X1"),
        ("G0 X1*62", "G0 X1"),
        ("/G0 X1", "G0 X1"),
        ("G21 G1 F1200 X1\nG20\nX1", "F20 X1, F20 X25.4"),
        ("G20 F12\nG21 G1 X1", "F5.08 X1"),
        ("G20 G1 X1 F60", "F25.4 X25.4"),
        ("G1 F60 X1\nG1 A90 F360\nA0", "F1 X1, F6 X1A90, F6 X1"),
        ("G20 G1 A90 F60", "F1 A90"),
        ("G93 G1 X1 F2", "T30 X1"),
        ("G93 G1 X1 F2\nG94\nX2 F60", "T30 X1, F1 X2"),
        ("G91 G0 X0.1\nX0.1\nX0.1", "G0 X0.1, G0 X0.2, G0 X0.3"),
        ("G2 X2 I1 F60", "cw(1 0)+0 X2"),
        ("G3 X2 R1 P2 F60", "ccw(1 0)+1 X2"),
        ("G2 I1 F60", "cw(1 0)+0 0"),
        ("G18 G3 X2 Z0 I1 K0 F60", "ccw(0 1)+0 X2"),
        ("G9 G1 X1 F60", "F1 X1"),
        ("", ""),
        ("%", ""),
    ] {
        assert_eq!(story(&read(text, MILL)), expected, "{text:?}");
    }
    for (line, part) in [
        ("G1 X1e F60", "column 4: the E behind the number of \"X\" may be an exponent or a word"),
        ("G1 X1e-5.5", "is not a number"),
        (
            "G1 X10 Y20E3 F1000",
            "column 8: the E behind the number of \"Y\" may be an exponent or a word",
        ),
        ("G1 X1e5", "may be an exponent or a word"),
        ("G1 X1E-05", "may be an exponent or a word"),
        ("G1 X1E-0.5", "may be an exponent or a word"),
        ("g1 x20e-3", "may be an exponent or a word"),
        ("G0 X1 E-05", "word E"),
        ("G2E1", "G2 needs axis words"),
        ("G9E1", "word E"),
        ("M3e1", "word E"),
        ("T1e1 M6", "word E"),
        ("G1 X1.2.3", "column 4"),
        ("G10 L2 P1 R45", "column 11: R45: it must be 0"),
        ("G1.01 X1", "G1.01: it must be from 0 to 5999.9, with at most one decimal"),
        ("G1 X--1", "is not a number"),
        ("G1 X-", "is not a number"),
        ("G1 X.", "is not a number"),
        ("G1 X1,5", "is not a number"),
        ("G1 X1-5", "is not a number"),
        ("G1 X", "no number behind \"X\""),
        ("G1 Xa", "column 4: no number behind \"X\""),
        ("G1 X1e+400", "too large"),
        ("G1 X1e+9 F1", "X would go to 1000000000 mm"),
        ("G1 X1000001 F1", "column 4: X would go to 1000001 mm"),
        ("G1 12 X1", "unexpected character '1'"),
        ("G1 X#1", "parameters and expressions"),
        ("G1 X[1+2]", "parameters and expressions"),
        ("#1=5", "parameters and expressions"),
        ("G1 (open", "column 4: the comment is not closed"),
        ("G1 (a (b) X1)", "a comment in a comment"),
        ("G1 ) X1", "unexpected character ')'"),
        ("G1 X1 !", "column 7: unexpected character '!'"),
        ("$H", "$H homes, which needs the machine"),
        ("G1 X1\u{a0}Y1", "unexpected character"),
        ("(\u{e9}) G1 X!", "column 9: unexpected character"),
        ("G0 X1*84", "the sum behind \"*\" is 84, that of the line is 62"),
        ("G0 X1*", "unexpected character '*'"),
        ("G0 X1 % X2", "\"%\" must stand alone"),
        ("% X1", "\"%\" must stand alone"),
        ("/2 G0 X1", "\"/\" must be the first"),
        ("G0 / X1", "\"/\" must be the first"),
        ("G0 X1 N5", "N must be the first"),
        ("o100 sub", "O words with names or keywords"),
        ("O<name> call", "O words with names or keywords"),
        ("O100 G0 X1", "O words with names or keywords"),
        ("G2 X1 F60", "column 1: G2 needs a centre"),
        ("G3 X1 Y1 Z1 F60", "G3 needs a centre"),
        ("G2", "G2 needs axis words"),
        ("G2 X9 R1 F60", "no arc of radius 1 mm joins points 9.000000 mm apart"),
        ("G90.1 G2 X2 I1 F60", "both words of its centre"),
        ("G2 X2 I1 P1.5 F60", "P1.5: it must be a whole number"),
        ("G1 X1 F0", "F0: it must be from"),
        ("G1 X1 F-5", "F-5"),
        ("G93 G1 X1", "an F word in every line under G93"),
        ("G4", "G4 needs a P word"),
        ("G4 S30", "G4 needs a P word"),
        ("G4 P-1", "P-1"),
        ("X1", "axis words without a motion code"),
        ("G53 G2 X1 I1 F60", "G53 needs G0 or G1"),
        ("G53", "G53 needs axis words"),
        ("G5 X1 P1 Q1 F60", "I and J where no G5 is before it"),
        ("G5 X1 I1 J1 F60", "G5 needs P and Q"),
        ("G5.1 X1 I1 F60", "G5.1 needs I and J together"),
        ("G18 G5.1 X1 I1 J1 F60", "G5.1 needs the XY plane"),
        ("G81 X1 R1 F60", "the bottom of the hole"),
        ("G81 X1 Z-1 F60", "an R word"),
        ("G81 X1 Z5 R1 F60", "a bottom below its R level"),
        ("G82 X1 Z-1 R1 F60", "a P word"),
        ("G83 X1 Z-1 R1 F60", "a Q word"),
        ("G83 X1 Z-1 R1 Q0 F60", "Q0"),
        ("G83 X1 Z-1 R1 Q1e-5 F60", "Q0.00001"),
        ("G81 X1 Z-1 R1 L0 F60", "L0"),
        ("G81", "G81 needs axis words"),
        ("G81 X1 A5 Z-1 R1 F60", "word A"),
        ("M98", "M98 needs a P word"),
        ("M98 P7", "there is no O7 in this file"),
        ("M99", "M99 outside of a subprogram"),
        ("S-1", "S-1"),
        ("T1.5 M6", "T1.5"),
        ("G68 R90 X1", "both coordinates of its centre"),
        ("G68 X0 Y0", "an R word"),
        ("G91 G68 X0 Y0 R5", "G68 under G91"),
    ] {
        let found = errors(line, MILL);
        assert!(found.len() == 1 && found[0].contains(part), "{line}: {found:?}");
        assert!(found[0].starts_with("line 1"), "{line}: {found:?}");
    }
}

#[test]
fn printers() {
    for (text, expected) in [
        ("M201 X500 Y500 Z100 E5000\nG1 X1 F60", "F1 X1"),
        ("M203 X500 Y500 Z10 E60\nM205 X8.00 Y8.00 Z0.40 E4.50\nM204 P1000 R1000 T1000", ""),
        ("M862.3 P \"MK3S\" ; printer model check\nM862.1 P0.4", ""),
        ("M117 Printing X5 Y5 layer (3)\nG1 X1 F60", "F1 X1"),
        ("M118 A1 hello X5", ""),
        ("M84 X Y E\nM84", "M84, M84"),
        ("M82\nM83\nM104 S200 T0\nM109 S200\nM140 S60\nM190 S60\nM106 S255\nM107", ""),
        ("M600 X50 Y50", "M600!"),
        ("G1 X1 E-5 F60", "F1 X1"),
        ("G1 X1E5 F60", "F1 X1"),
        ("G92E0\nG1E-5F60\nG1X1", "F1 X1"),
        ("G1X1Y2E-0.5F60", "F1 X1Y2"),
        ("G1 X1e-05 F60", "F1 X0.00001"),
        ("G1 E-0.8 F2100\nG1 X1", "F35 X1"),
        ("G92 E0\nG1 X1 F60", "F1 X1"),
        // G0 is run as G1: at the feed in force.
        ("G0 X1 F600\nG1 Y1 F60\nG0 X2\nG0 X3 F120", "F10 X1, F1 X1Y1, F1 X2Y1, F2 X3Y1"),
        ("G1 X5 F60\nG92 X0 E0\nG1 X1", "F1 X5, F1 X6"),
        ("G4 P500", "dwell 0.5"),
        ("G4 S30", "dwell 30"),
        ("G4 S1 P500", "dwell 1"),
        ("G4", "dwell 0"),
        ("G0 X1 Y2 Z3\nG28", "G0 X1Y2Z3, G0 Z3, G0 0"),
        ("G0 X1 Y2 Z3\nG28 X Y", "G0 X1Y2Z3, G0 Z3"),
        ("G0 X1 Y2 Z3\nG28 X0 Y0", "G0 X1Y2Z3, G0 Z3"),
        ("G0 X1 Y2 Z3\nG28 W", "G0 X1Y2Z3, G0 Z3, G0 0"),
        ("G0 X1\nG28 Z5", "G0 X1"),
        ("G10\nG11\nG10 S1", ""),
        ("M73 P0 R10\nM900 K0.05\nM221 S95\nM572 S0.02", ""),
        ("N3 T0*57", "T:0"),
        ("M0 Click to continue X5", "M0!"),
        ("M3 S255\nM5", "M3:255, M5"),
        ("G2 X2 I1 E0.5 F60", "cw(1 0)+0 X2"),
        ("G5 X4 Y0 I1 J2 P-1 Q2 E1 F60", "cubic X4"),
        ("M400", ""),
        ("M92 E415", ""),
    ] {
        assert_eq!(story(&read(text, Dialect::Marlin)), expected, "{text:?}");
    }
    let before = "G1 X1 Y1 F60\n";
    for (line, part) in [
        ("M92 X80", "M92"),
        ("G29 X10 Y20", "G29 (levelling of the bed)"),
        ("G30 X5 Y5", "G30 (probing)"),
        ("G38.2 Z-5", "probing"),
        ("G61 X", "G61"),
        ("G42 I1 J1", "G42"),
        ("G10 L2 P1 X50", "no code of this line takes the word L"),
        ("M206 X5", "M206 (another home position)"),
        ("M218 T1 X25", "M218"),
        ("M290 Z0.1", "M290"),
        ("M665 L200", "M665"),
        ("M808 L5", "M808"),
        ("M104 S200 G1 X5", "M104 must be the only code"),
        ("G1 X1E-05", "may be an exponent or a word"),
        ("G1 x1e5", "may be an exponent or a word"),
        ("START_PRINT BED_TEMP=60", "no number behind \"S\""),
        ("M5999 X5", "M5999 is not known"),
        ("M3 S5 X5", "word X"),
        ("G81 X1 Z-1 R1", "G81 is not known"),
        ("T1 S1", "word S"),
        ("T1 F3000 X5", "word X"),
        ("G52 X5", "G52 is not known"),
        ("G92", "G92 without axis words is read in two ways"),
        ("G2 X3 I1 P2", "word P"),
        ("M862.3 P \"MK3S", "not closed"),
        ("G1 X \"5\"", "no number behind"),
    ] {
        let found = errors(&format!("{before}{line}"), Dialect::Marlin);
        assert!(found.len() == 1 && found[0].contains(part), "{line}: {found:?}");
    }
}

/// A header of a slicer, as it comes.
#[test]
fn a_header_of_a_printer_is_told_and_read() {
    let text = "; generated by PrusaSlicer 2.7.1+linux on 2024-02-02\n;\nM73 P0 R31\n\
        M201 X1000 Y1000 Z200 E5000 ; sets maximum accelerations, mm/sec^2\nM203 X200 Y200 Z12 E120\n\
        M204 P1250 R1250 T1250\nM205 X8.00 Y8.00 Z0.40 E4.50\nM205 S0 T0\n;TYPE:Custom\n\
        M862.3 P \"MK3S\" ; printer model check\nM862.1 P0.4 ; nozzle diameter check\nM115 U3.13.2\nG90\nM83\n\
        M104 S215\nM140 S60\nM190 S60\nM109 S215\nG28 W ; home all without mesh bed level\nG80 ; mesh bed leveling\n\
        G92 E0.0\nG1 X60.0 E9.0 F1000.0 ; intro line\nG1 X100.0 E12.5 F1000.0\nG21\nG1 Z.2 F720\n\
        M117 done\nG4 P500 ; dwell\nM221 S100\nM107\nM84 X Y E\n";
    let (program, findings) = examine(text, ReadOptions::DEFAULT);
    assert!(findings.iter().all(|finding| !finding.is_error()), "{findings:?}");
    assert_eq!(story(&program), "F16.666667 X60, F16.666667 X100, F12 X100Z0.2, dwell 0.5, M84");
    assert!(
        findings[0].to_string().contains("--dialect marlin") && findings[0].line == 0,
        "{findings:?}"
    );
    // The same said to be of a mill is refused throughout.
    assert!(errors(text, MILL).len() > 12, "{:?}", errors(text, MILL));
}

#[test]
fn every_place_is_listed_at_once() {
    let text = "G1 X1 F60\nM201 X5\nG1 X2 Q1\nG2 X4\nG1 X5\nG42\nX6 !\nX7";
    let found = errors(text, MILL);
    let lines: Vec<&str> = found.iter().map(|text| &text[..6]).collect();
    assert_eq!(lines, ["line 2", "line 3", "line 4", "line 6", "line 7"], "{found:?}");
    // A refused line is taken for where it leads, so that the arc behind it is not blamed.
    assert_eq!(errors("G1 X10 Q1 F60\nG2 X20 R5.0", MILL).len(), 1);
    let long: String = (0..100).map(|_| "M201 X5\n").collect();
    let error = gcode::parse(&long, 1.0).unwrap_err().to_string();
    assert!(
        error.starts_with("100 places are refused:") && error.ends_with("and 80 more"),
        "{error}"
    );
}

#[test]
fn the_core_is_asked_too() {
    let (program, findings) =
        examine("G1 X1 F60\nG2 X3 I5\nG1 X4 F9e+8\nG93 X5 F1e-6\nG94", options(MILL));
    assert!(findings.iter().all(|finding| !finding.is_error()), "{findings:?}");
    let lines: Vec<u32> =
        validate(&program, &Machine::default()).iter().map(|finding| finding.line).collect();
    assert_eq!(lines, [2, 3, 4]);
}

#[test]
fn lenient_leaves_out_what_cannot_move() {
    let lenient = ReadOptions { lenient: true, ..options(MILL) };
    for (text, expected) in [
        ("M117 hello X5\nG0 X1", "G0 X1"),
        ("M201 X500\nG0 X1", "G0 X1"),
        ("G0 X1 E5", "G0 X1"),
        ("M104 S200\nM84 X Y\nG0 X1", "G0 X1"),
        ("M150\nG0 X1", "G0 X1"),
    ] {
        let (program, findings) = examine(text, lenient);
        assert!(findings.iter().all(|finding| !finding.is_error()), "{text}: {findings:?}");
        assert!(!findings.is_empty(), "{text}: it must be said");
        assert_eq!(story(&program), expected, "{text}");
    }
    for text in ["G42", "M98 P5", "G31 Z-1", "M600 X5", "G55", "M206 X5", "M1000", "G0 X1 Q5"] {
        let (_, findings) = examine(text, lenient);
        assert!(findings.iter().any(Finding::is_error), "{text}");
    }
}

#[test]
fn it_begins_where_the_machine_stands() {
    let mut start = [0.0; AXES];
    (start[0], start[1], start[3]) = (10.0, 0.000_000_123, 45.5);
    let from = ReadOptions { start, ..options(MILL) };
    let (program, _) = examine("G91 G1 X1 F60\nG90 Z5\nG92 X0\nX1", from);
    let ends: Vec<Point> =
        program.moves.iter().filter_map(|step| step.path.end().copied()).collect();
    for (end, (x, z)) in ends.iter().zip([(11.0, 0.0), (11.0, 5.0), (12.0, 5.0)]) {
        // Axes that are never named have not the smallest move.
        assert_eq!((end[1].to_bits(), end[3].to_bits()), (start[1].to_bits(), start[3].to_bits()));
        assert_eq!((end[0], end[2]), (x, z));
    }
    assert_eq!(program.start.map(f64::to_bits), start.map(f64::to_bits));
    assert!(!program.uses[3]);
}

#[test]
fn the_machine_brings_offsets_tools_and_reference_points() {
    let machine = Machine::parse(
        "[work.G55]\nX = 100\nY = 50\n[reference.G28]\nZ = 30\n[reference.G30]\nX = -5\n[tools]\n1 = 75.5\n12 = 20\n",
    )
    .unwrap();
    let setup: Setup = machine.setup();
    let options = ReadOptions { setup: &setup, ..options(MILL) };
    for (text, expected) in [
        ("G55 G0 X1", "G0 X101"),
        ("G43 H1 G0 Z5\nG43 H12 Z5", "G0 Z80.5, G0 Z25"),
        // G43 on its own is for the tool in the spindle, not for one that is only got ready.
        ("T12 M6\nG43 G0 Z1", "M6:12!, G0 Z21"),
        ("T1 M6\nT12\nG43 G0 Z1\nM6\nG43 Z1", "M6:1!, T:12, G0 Z76.5, M6:12!, G0 Z21"),
        ("M61 Q12\nT1\nG43 G0 Z1", "M61:12, T:1, G0 Z21"),
        ("T2 M6\nG43 H0 G0 Z1", "M6:2!, G0 Z1"),
        ("G91 G28 Z0", "G0 Z30"),
        ("G30 X1", "G0 X1, G0 X-5"),
    ] {
        let (program, findings) = examine(text, options);
        assert!(findings.iter().all(|finding| !finding.is_error()), "{text}: {findings:?}");
        assert_eq!(story(&program), expected, "{text}");
    }
    for (text, part) in [
        ("T12 M6\nG43 Z1", "without a motion code"),
        ("T12\nG43 G0 Z1", "G43 needs an H word"),
        ("T12 M6\nG43 H0 G0 Z1", "line 2, column 5: G43 with H0 is read in two ways"),
        ("T2 M6\nG43 G0 Z1", "no length of tool 2"),
    ] {
        let (_, findings) = examine(text, options);
        assert!(findings.iter().any(|finding| finding.to_string().contains(part)), "{findings:?}");
    }
    for (text, part) in [
        ("[work.G60]\nX = 1\n", "work.G60"),
        ("[work.G55]\nQ = 1\n", "work.G55.Q"),
        ("[reference.G29]\nX = 1\n", "reference.G29"),
        ("[tools]\nbig = 1\n", "tools.big"),
        ("[work.G55]\nX = 1e9\n", "work.G55.X"),
    ] {
        let error = format!("{:#}", Machine::parse(text).unwrap_err());
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn subprograms_end_where_they_should() {
    for (text, part) in [
        ("G0 X1\nO5\nG0 X2\nM2", "runs on into O5"),
        ("M98 P1\nM30\nO1\nG0 X1\nO2\nM99", "O1 runs on into O2"),
        ("M98 P1\nM30\nO1\nG0 X1", "the file ends before M99 of the subprogram O1"),
        ("O9\nG0 X1\nO1\nG0 X2\nM99", "runs on into O1"),
        ("M98 P1\nM30\nO1\nM98 P1\nM99", "calls go deeper than 8"),
        ("M98 P1 L2 Q5\nM30", "word Q"),
        ("M98 P30001\nM30", "P30001"),
        ("M98 P1\nM30\nO1\nG0 X1\nM99\nO1\nG0 X2\nM99", "there is more than one O1"),
    ] {
        let found = errors(text, MILL);
        assert!(found.len() == 1 && found[0].contains(part), "{text}: {found:?}");
    }
    // The words of a cycle are not those of another.
    assert!(errors("G81 X1 Z-1 R1 F60\nG82 X2 Z-1 P0", MILL)[0].contains("R word"));
    // What is wrong in a subprogram is said once.
    assert_eq!(errors("M98 P1 L5\nM30\nO1\nG42\nM99", MILL).len(), 1);
}

#[test]
fn dialects_differ_where_they_say() {
    // grbl begins with G0 in force.
    assert_eq!(story(&read("X5", Dialect::Grbl)), "G0 X5");
    assert_eq!(errors("X5", MILL).len(), 1);
    let skip = ReadOptions { block_delete: true, ..options(MILL) };
    assert_eq!(story(&examine("/G0 X1\nG0 Y1", skip).0), "G0 Y1");
    let (_, findings) = examine("G4 P500", ReadOptions::DEFAULT);
    assert!(findings[0].message.contains("500 s"), "{findings:?}");
}

#[test]
fn endings_and_kinds() {
    for name in
        ["a.g", "a.gc", "a.mpf", "a.eia", "a.cnc", "a", "a.NC", "a.tap", "a.ngc", "a.gcode", "-"]
    {
        let (program, _) = inspect_bytes(Path::new(name), b"G0 X1", ReadOptions::DEFAULT).unwrap();
        assert_eq!(program.moves.len(), 1, "{name}");
    }
    let curve = br#"{"degree": 1, "control_points": [[0, 0], [1, 1]], "knots": [0, 0, 1, 1]}"#;
    assert!(inspect_bytes(Path::new("-"), curve, ReadOptions::DEFAULT).is_ok());
    assert!(inspect_bytes(Path::new("a.doc"), b"G0 X1", ReadOptions::DEFAULT).is_err());
}

/// An arc is not told to go where only its centre lies.
#[test]
fn a_centre_out_of_range_is_named() {
    for line in ["G2 X10 R1000001 F100", "G2 X10 R1000000000 F100", "G2 X10 J-1000001 F100"] {
        let found = errors(line, MILL);
        assert!(
            found[0].contains("the arc's centre would lie beyond +-1000000 mm of Y"),
            "{found:?}"
        );
    }
}

/// Whatever the bytes, it is read or refused; and what is read stays in range.
#[test]
fn any_order_of_words_gives_the_same() {
    let words = ["G1", "X1.5", "Y-2", "F60", "M8", "S100", "G90"];
    let expected = story(&read(&words.join(" "), MILL));
    for shift in 0..words.len() {
        let mut turned = words;
        turned.rotate_left(shift);
        for text in
            [turned.join(" "), turned.concat(), turned.concat().to_lowercase(), turned.join("\t")]
        {
            assert_eq!(story(&read(&text, MILL)), expected, "{text}");
        }
    }
    assert_eq!(Code::g(611).to_string(), "G61.1");
}

/// A feed that is refused has been said; that moves behind it have none is no other finding.
#[test]
fn a_feed_that_is_refused_is_told_once() {
    for text in ["F0\nG1 X5\nX6", "G1 X5 F0\nX6", "G1 F0\nX5\nF0.5\nX6"] {
        let (_, findings) = examine(text, options(MILL));
        assert_eq!(findings.len(), 1, "{findings:?}");
        assert!(findings[0].to_string().contains("F0: it must be from"), "{findings:?}");
    }
    let (_, findings) = examine("G1 X5\nX6\nF60\nX7", options(MILL));
    assert_eq!(findings.len(), 1, "{findings:?}");
    assert!(findings[0].to_string().contains("no F word in force"), "{findings:?}");
}

/// The share of the feed that a printer's program asks for is the controller's business; nobody is to take it for done.
#[test]
fn a_share_of_the_feed_is_handed_on_and_said_to_be() {
    for (text, said) in [("M220 S50\nG1 X5 F600", 1), ("M220 S100\nG1 X5 F600", 0)] {
        let (program, findings) = examine(text, options(Dialect::Marlin));
        let notes: Vec<String> = findings.iter().map(ToString::to_string).collect();
        assert_eq!(notes.len(), said, "{notes:?}");
        assert!(notes.iter().all(|note| note.contains("M220 S50 is handed on")), "{notes:?}");
        assert!(story(&program).contains("M220"), "{text}");
    }
}

/// What stands behind the end may have been meant: it is told, but for subprograms, which belong there, and remarks.
#[test]
fn lines_behind_the_end_are_told() {
    let told = |text: &str| {
        let (_, found) = examine(text, options(Dialect::LinuxCnc));
        found.iter().map(|found| (found.line, found.message.clone())).collect::<Vec<_>>()
    };
    let end = "the program ends in line 2: nothing behind it is read";
    assert_eq!(told("G1 X1 F1\nM2\n\n(x)\nG1 X3\nG1 X4\n"), [(5, end.to_owned())]);
    assert_eq!(told("%\nG1 X1 F1\n%\nG1 X3\n").len(), 1);
    for text in ["G1 X1 F1\nM2\n%\n", "G1 X1 F1\nM30\n", "M98 P1\nM30\nO1\nG1 X1 F1\nM99\n"] {
        assert!(told(text).is_empty(), "{text}");
    }
}
