//! Folds constant operations. The numbers are the opcodes of the SPIR-V specification.

/// The types of values that can be constants: numbers of 32 bits, and booleans.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Bool,
    Int,
    Float,
}

/// Whether [`fold`] can compute an operation. Floating-point arithmetic is left to the device, because its rounding may differ.
pub fn is_known(operation: u32) -> bool {
    matches!(operation, 83 | 124 | 126 | 128 | 130 | 132 | 134 | 135 | 137..=139 | 164..=191 | 194..=200)
}

/// Returns the bits of the result of an operation. Returns `None` if the result depends on an unknown operand, or if the
/// specification leaves it undefined. The result and the operands are scalars.
pub fn fold(operation: u32, operands: [Option<u32>; 3]) -> Option<u32> {
    let [a, b, c] = operands;
    // A single operand may determine the result.
    match operation {
        166 if a == Some(1) || b == Some(1) => return Some(1),
        167 if a == Some(0) || b == Some(0) => return Some(0),
        169 => return if a? != 0 { b } else { c },
        _ => (),
    }
    let a = a?;
    match operation {
        83 | 124 => return Some(a),
        126 => return Some(a.wrapping_neg()),
        168 => return Some(u32::from(a == 0)),
        200 => return Some(!a),
        _ => (),
    }
    let b = b?;
    let (signed_a, signed_b) = (a.cast_signed(), b.cast_signed());
    let truth = |truth: bool| Some(u32::from(truth));
    match operation {
        128 => Some(a.wrapping_add(b)),
        130 => Some(a.wrapping_sub(b)),
        132 => Some(a.wrapping_mul(b)),
        134 => a.checked_div(b),
        135 => signed_a.checked_div(signed_b).map(i32::cast_unsigned),
        137 => a.checked_rem(b),
        138 => signed_a.checked_rem(signed_b).map(i32::cast_unsigned),
        139 => {
            // The result has the sign of the divisor.
            let rest = signed_a.checked_rem(signed_b)?;
            let adjust = rest != 0 && (rest < 0) != (signed_b < 0);
            Some(if adjust { rest.wrapping_add(signed_b) } else { rest }.cast_unsigned())
        }
        164 | 170 => truth(a == b),
        165 | 171 => truth(a != b),
        166 => Some(a | b),
        167 => Some(a & b),
        172 => truth(a > b),
        173 => truth(signed_a > signed_b),
        174 => truth(a >= b),
        175 => truth(signed_a >= signed_b),
        176 => truth(a < b),
        177 => truth(signed_a < signed_b),
        178 => truth(a <= b),
        179 => truth(signed_a <= signed_b),
        180..=191 => compare(operation, f32::from_bits(a), f32::from_bits(b)).map(u32::from),
        194 => a.checked_shr(b),
        195 => signed_a.checked_shr(b).map(i32::cast_unsigned),
        196 => a.checked_shl(b),
        197 => Some(a | b),
        198 => Some(a ^ b),
        199 => Some(a & b),
        _ => None,
    }
}

/// Compares numbers. Returns `None` for NaN, because every comparison has an ordered and an unordered form.
fn compare(operation: u32, a: f32, b: f32) -> Option<bool> {
    if a.is_nan() || b.is_nan() {
        return None;
    }
    Some(match operation {
        180 | 181 => a == b,
        182 | 183 => a != b,
        184 | 185 => a < b,
        186 | 187 => a > b,
        188 | 189 => a <= b,
        _ => a >= b,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(operation: u32, a: i32, b: i32) -> Option<u32> {
        fold(operation, [Some(a.cast_unsigned()), Some(b.cast_unsigned()), None])
    }

    #[test]
    fn integers_are_those_of_the_specification() {
        let signed = |operation, a, b| of(operation, a, b).map(u32::cast_signed);
        for (operation, a, b, expected) in [
            (128, i32::MAX, 1, i32::MIN),
            (130, 3, 5, -2),
            (132, -3, 5, -15),
            (135, -7, 2, -3),
            // The remainder has the sign of the dividend for opcode 138, and of the divisor for opcode 139.
            (138, -7, 2, -1),
            (138, 7, -2, 1),
            (139, -7, 2, 1),
            (139, 7, -2, -1),
            (139, -6, 2, 0),
            (195, -8, 1, -4),
            (196, 3, 2, 12),
            (197, 5, 3, 7),
            (198, 5, 3, 6),
            (199, 5, 3, 1),
        ] {
            assert_eq!(signed(operation, a, b), Some(expected), "{operation} of {a} and {b}");
        }
        assert_eq!(of(134, -2, 2), Some(0x7fff_ffff));
        assert_eq!(of(137, -1, 10), Some(5));
        assert_eq!(of(194, -8, 1), Some(0x7fff_fffc));
        assert_eq!(fold(126, [Some(5), None, None]), Some((-5i32).cast_unsigned()));
        assert_eq!(fold(200, [Some(0), None, None]), Some(u32::MAX));
        // The specification leaves these operations undefined.
        for operation in [134, 135, 137, 138, 139] {
            assert_eq!(of(operation, 1, 0), None);
        }
        assert_eq!(of(135, i32::MIN, -1), None);
        assert_eq!(of(196, 1, 32), None);
    }

    #[test]
    fn comparisons_respect_sign() {
        type Compare = fn(i32, i32) -> bool;
        let ordered: [(u32, Compare); 12] = [
            (170, |a, b| a == b),
            (171, |a, b| a != b),
            (172, |a, b| a.cast_unsigned() > b.cast_unsigned()),
            (173, |a, b| a > b),
            (174, |a, b| a.cast_unsigned() >= b.cast_unsigned()),
            (175, |a, b| a >= b),
            (176, |a, b| a.cast_unsigned() < b.cast_unsigned()),
            (177, |a, b| a < b),
            (178, |a, b| a.cast_unsigned() <= b.cast_unsigned()),
            (179, |a, b| a <= b),
            (164, |a, b| a == b),
            (165, |a, b| a != b),
        ];
        for (operation, expected) in ordered {
            for (a, b) in [(1, 2), (2, 1), (-1, 1), (1, -1), (3, 3)] {
                assert_eq!(of(operation, a, b), Some(u32::from(expected(a, b))), "{operation} of {a} and {b}");
            }
        }
    }

    #[test]
    fn floats_are_compared_and_nothing_else() {
        let of = |operation, a: f32, b: f32| fold(operation, [Some(a.to_bits()), Some(b.to_bits()), None]);
        for (a, b) in [(1.0, 2.0), (2.0, 1.0), (-0.0, 0.0), (f32::INFINITY, 1.0)] {
            for unordered in 0..2 {
                let truths = [a == b, a != b, a < b, a > b, a <= b, a >= b].map(u32::from).map(Some);
                let folded: [_; 6] = std::array::from_fn(|i| of(180 + 2 * i as u32 + unordered, a, b));
                assert_eq!(folded, truths, "{a} and {b}");
            }
        }
        assert_eq!(of(184, f32::NAN, 1.0), None);
        // Opcode 129 adds floats.
        assert!(!is_known(129));
    }

    #[test]
    fn one_operand_may_decide() {
        for other in [None, Some(0), Some(1)] {
            assert_eq!(fold(166, [other, Some(1), None]), Some(1));
            assert_eq!(fold(167, [Some(0), other, None]), Some(0));
        }
        assert_eq!(fold(166, [None, Some(0), None]), None);
        assert_eq!(fold(167, [Some(1), None, None]), None);
        assert_eq!(fold(169, [Some(1), Some(7), None]), Some(7));
        assert_eq!(fold(169, [Some(0), Some(7), None]), None);
        assert_eq!(fold(168, [Some(0), None, None]), Some(1));
    }
}
