//! Iterates over the instructions of a SPIR-V module. Opcodes are numbered as in the SPIR-V 1.6 specification.

/// The number of words before the first instruction.
pub const HEADER: usize = 5;

/// An instruction of a module.
#[derive(Clone, Copy)]
pub struct Instruction<'a> {
    /// The opcode of the instruction.
    pub operation: u32,
    /// The index of the instruction's first word in the module.
    pub at: usize,
    /// The words of the instruction, including the first. In a truncated module, these are fewer words than the instruction's length.
    pub words: &'a [u32],
}

/// Returns the instructions of a module, starting at the word `from`.
pub fn instructions(module: &[u32], from: usize) -> impl Iterator<Item = Instruction<'_>> {
    let mut at = from;
    std::iter::from_fn(move || {
        let first = *module.get(at)?;
        let end = (at + (first >> 16).max(1) as usize).min(module.len());
        let instruction = Instruction { operation: first & 0xffff, at, words: &module[at..end] };
        at = end;
        Some(instruction)
    })
}

/// Returns all instructions of a module.
pub fn all_instructions(module: &[u32]) -> impl Iterator<Item = Instruction<'_>> {
    instructions(module, HEADER)
}
