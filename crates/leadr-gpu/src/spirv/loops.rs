//! Rewrites the loop controls of SPIR-V.

use super::{HEADER, OP_LOOP_MERGE};

/// Removes every `[[unroll]]` from SPIR-V, so that the driver decides which loops to unroll.
pub fn leave_loops_to_driver(words: &mut [u32]) {
    const CONTROL: usize = 3;
    const UNROLL: u32 = 1;
    let mut at = HEADER;
    while at < words.len() {
        let (length, operation) = (words[at] >> 16, words[at] & 0xffff);
        if operation == OP_LOOP_MERGE {
            words[at + CONTROL] &= !UNROLL;
        }
        at += length.max(1) as usize;
    }
}

#[cfg(test)]
mod tests {
    use super::super::all_instructions;
    use super::*;

    /// Returns the loop controls in SPIR-V.
    fn controls(words: &[u32]) -> Vec<u32> {
        all_instructions(words).filter(|i| i.operation == OP_LOOP_MERGE).map(|i| i.words[3]).collect()
    }

    #[test]
    fn loops_are_left_to_the_driver_and_nothing_else_changes() {
        let shader =
            leadr_shaders::SHADERS.iter().find(|shader| shader.name == "passes/filter/filter_shade.frag").unwrap();
        let before = shader.words();
        let mut after = before.clone();
        leave_loops_to_driver(&mut after);
        let marked = controls(&before).iter().filter(|&&control| control & 1 != 0).count();
        assert!(marked > 5 && marked < controls(&before).len(), "{marked} of {}", controls(&before).len());
        assert!(controls(&after).iter().all(|&control| control == 0));
        assert_eq!(before.iter().zip(&after).filter(|(a, b)| a != b).count(), marked);
        let header = after[..5].to_vec();
        leave_loops_to_driver(&mut after[..5]);
        assert_eq!(after[..5], header);
    }
}
