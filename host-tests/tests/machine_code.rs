//! What the target bench reads from machine code: planted code whose longest path is known, and code of which nothing can be
//! told.

#[path = "../benches/target/listing.rs"]
mod listing;
#[path = "../benches/target/longest.rs"]
mod longest;

use listing::Listing;
use longest::{Rule, longest};
use std::fmt::Write;

/// Name and instructions: address, mnemonic, operands.
type Function<'a> = (&'a str, &'a [(u32, &'a str, &'a str)]);

/// A listing as objdump prints it: functions, and lines of address, mnemonic and operands.
fn listed(functions: &[Function<'_>]) -> Listing {
    let mut text = String::new();
    for (name, code) in functions {
        let _ = writeln!(text, "{:08x} <{name}>:", code[0].0);
        for (address, mnemonic, operands) in *code {
            let _ = writeln!(text, " {address:x}:\t{mnemonic}\t{operands}");
        }
        text.push('\n');
    }
    Listing::read(&text).unwrap()
}

const TWICE: Rule = Rule { function: "tick", contains: "subs", times: 2 };

fn most(functions: &[Function<'_>], rules: &[Rule]) -> Result<u64, String> {
    longest(&listed(functions), "tick", rules).map_err(|error| format!("{error:#}"))
}

#[test]
fn the_longer_branch_counts() {
    let code = [
        (0x10, "cmp", "r0, #0"),
        (0x12, "beq.n", "1a <tick+0xa>"),
        (0x14, "adds", "r0, #1"),
        (0x16, "adds", "r0, #1"),
        (0x18, "bx", "lr"),
        (0x1a, "cbz", "r1, 18 <tick+0x8>"),
        (0x1c, "it", "eq"),
        (0x1e, "popeq", "{r4, pc}"),
        (0x20, "b.n", "18 <tick+0x8>"),
    ];
    // cmp, beq, cbz, it, popeq, b, bx.
    assert_eq!(most(&[("tick", &code)], &[]), Ok(7));
}

#[test]
fn calls_count_with_what_they_call_and_in_the_tail() {
    let tick = [(0x10, "bl", "20 <inner>"), (0x14, "b.w", "20 <inner>")];
    let inner = [(0x20, "nop", ""), (0x22, "bx", "lr")];
    assert_eq!(most(&[("tick", &tick), ("inner", &inner)], &[]), Ok(2 + 2 * 2));
    let recursive = [(0x20, "bl", "10 <tick>"), (0x24, "bx", "lr")];
    let error = most(&[("tick", &tick), ("inner", &recursive)], &[]).unwrap_err();
    assert!(error.contains("tick calls itself"), "{error}");
    let by_pointer = [(0x10, "blx", "r3"), (0x12, "bx", "lr")];
    let error = most(&[("tick", &by_pointer)], &[]).unwrap_err();
    assert!(error.contains("a call by pointer"), "{error}");
    let computed = [(0x10, "mov", "pc, r3"), (0x12, "bx", "lr")];
    let error = most(&[("tick", &computed)], &[]).unwrap_err();
    assert!(error.contains("where to?"), "{error}");
}

/// Two rounds of a loop with an early exit, in which there is another.
#[test]
fn a_loop_needs_a_bound() {
    let code = [
        (0x10, "movs", "r0, #2"),
        (0x12, "cbz", "r1, 1c <tick+0xc>"),
        (0x14, "nop", ""),
        (0x16, "subs", "r0, #1"),
        (0x18, "bne.n", "12 <tick+0x2>"),
        (0x1a, "bx", "lr"),
        (0x1c, "nop", ""),
        (0x1e, "nop", ""),
        (0x20, "nop", ""),
        (0x22, "nop", ""),
        (0x24, "bx", "lr"),
    ];
    // movs; four of a round; then the exit at its head with five, longer than four to the end and bx.
    assert_eq!(most(&[("tick", &code)], &[TWICE]), Ok(1 + 4 + 1 + 5));
    let error = most(&[("tick", &code)], &[]).unwrap_err();
    assert!(error.contains("a loop without a bound at 12"), "{error}");
    let other = Rule { function: "", contains: "strex", times: 2 };
    assert!(most(&[("tick", &code)], &[other]).is_err());

    let nested = [
        (0x10, "movs", "r0, #2"),
        (0x12, "vsub.f32", "s0, s1, s2"),
        (0x16, "strex", "r1, r2, [r3]"),
        (0x1a, "cmp", "r1, #0"),
        (0x1c, "bne.n", "16 <tick+0x6>"),
        (0x1e, "subs", "r0, #1"),
        (0x20, "bne.n", "12 <tick+0x2>"),
        (0x22, "bx", "lr"),
    ];
    let inner = || Rule { function: "", contains: "strex", times: 3 };
    let error = most(&[("tick", &nested)], &[inner()]).unwrap_err();
    assert!(error.contains("without a bound at 12"), "{error}");
    let outer = Rule { function: "", contains: "vsub", times: 2 };
    assert_eq!(most(&[("tick", &nested)], &[outer, inner()]), Ok(1 + 2 * (1 + 3 * 3 + 2) + 1));
    // A loop of one instruction, and one from the first on.
    let short = [(0x10, "nop", ""), (0x12, "bne.n", "12 <tick+0x2>"), (0x14, "bx", "lr")];
    assert!(most(&[("tick", &short)], &[]).unwrap_err().contains("without a bound"));
    let first = [(0x10, "nop", ""), (0x12, "bne.n", "10 <tick+0x0>"), (0x14, "bx", "lr")];
    assert!(most(&[("tick", &first)], &[TWICE]).unwrap_err().contains("first instruction"));
}

#[test]
fn a_loop_with_two_entries_has_no_bound() {
    let code = [
        (0x10, "cbz", "r0, 14 <tick+0x4>"),
        (0x12, "subs", "r0, #1"),
        (0x14, "nop", ""),
        (0x16, "bne.n", "12 <tick+0x2>"),
        (0x18, "bx", "lr"),
    ];
    let error = most(&[("tick", &code)], &[TWICE]).unwrap_err();
    assert!(error.contains("a loop with 2 entries"), "{error}");
}

#[test]
fn a_table_leads_to_all_its_targets() {
    let code = [
        (0x10, "tbb", "[pc, r0]"),
        (0x14, ".word", "0x02050302"),
        (0x18, "bx", "lr"),
        (0x1a, "nop", ""),
        (0x1c, "nop", ""),
        (0x1e, "nop", ""),
        (0x20, "bx", "lr"),
    ];
    // The last entry (5) leads to 1e; the longest (3) to 1a.
    assert_eq!(most(&[("tick", &code)], &[]), Ok(1 + 4));
}
