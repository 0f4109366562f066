//! What is changed in SPIR-V before the driver sees it. Numbers are those of the SPIR-V 1.6 specification.

mod fold;
mod loops;
mod specialize;

pub(super) use loops::leave_loops_to_driver;
pub(super) use specialize::specialized;

/// Words before the first instruction, and which of them is above every identifier.
const HEADER: usize = 5;
const BOUND: usize = 3;
const OP_LOOP_MERGE: u32 = 246;

/// An instruction of a module.
#[derive(Clone, Copy)]
struct Instruction<'a> {
    operation: u32,
    /// Where it begins in the module.
    at: usize,
    /// All of it, its first word included.
    words: &'a [u32],
}

/// The instructions of a module from one of its words on.
fn instructions(module: &[u32], from: usize) -> impl Iterator<Item = Instruction<'_>> {
    let mut at = from;
    std::iter::from_fn(move || {
        let first = *module.get(at)?;
        let end = (at + (first >> 16).max(1) as usize).min(module.len());
        let instruction = Instruction { operation: first & 0xffff, at, words: &module[at..end] };
        at = end;
        Some(instruction)
    })
}

/// All instructions of a module.
fn all_instructions(module: &[u32]) -> impl Iterator<Item = Instruction<'_>> {
    instructions(module, HEADER)
}
