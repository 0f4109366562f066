//! Tests the parts of the build script that read shaders, and their errors.

use leadr_glsl::constants::{Floats, enum_from_glsl, rust_from_glsl};
use leadr_glsl::reflect::{Constant, ConstantKind, interface};

#[test]
fn plain_constants_become_rust_with_their_comments() {
    let glsl = "// A file.\n#ifndef X\n#define X\n\n// Across.\n// In pixels.\nconst uint SIDE = 0xffu;\n\
                const int MORE = SIDE + 2;\nconst float HALF = 0.5;\n#endif\n";
    let rust = "/// Across.\n/// In pixels.\npub const SIDE: u32 = 0xff;\npub const MORE: i32 = SIDE + 2;\n\
                pub const HALF: f32 = 0.5;\n";
    assert_eq!(rust_from_glsl(glsl, Floats::F32).unwrap(), rust);
    let colour = "const vec3 AIR = vec3(0.1, 0.2, 0.3);";
    let rust = "pub const AIR: glam::DVec3 = glam::DVec3::new(0.1, 0.2, 0.3);\n";
    assert_eq!(rust_from_glsl(colour, Floats::F64).unwrap(), rust);
    for wrong in ["uniform float x;", "const mat3 M = mat3(1.0);", "const int A = 1"] {
        let error = rust_from_glsl(&format!("\n{wrong}"), Floats::F32).unwrap_err();
        assert!(error.starts_with("line 2") && error.contains(wrong), "{error}");
    }
}

#[test]
fn numbers_of_an_enum_are_found_among_other_code() {
    let glsl =
        "const int KIND_A = 0; // first\nfloat f() { return 1.0; }\nconst int KIND_B_C = 1;\nconst int OTHER = 1;\n";
    assert_eq!(
        enum_from_glsl(glsl, "KIND_").unwrap(),
        "/// `KIND_A`\npub const A: isize = 0;\n/// `KIND_B_C`\npub const B_C: isize = 1;\n"
    );
    assert!(enum_from_glsl(glsl, "NONE_").is_err());
    assert!(enum_from_glsl("const int KIND_A = 0;\nconst int KIND_B = 0;", "KIND_").is_err());
}

/// Returns a module of signed constants with these names, of one letter each, and these numbers.
fn module(constants: &[(u8, u32)]) -> Vec<u32> {
    let instruction = |opcode: u32, operands: &[u32]| {
        let head = (operands.len() as u32 + 1) << 16 | opcode;
        std::iter::once(head).chain(operands.iter().copied()).collect::<Vec<_>>()
    };
    let mut words = vec![0x0723_0203, 0x0001_0600, 0, 100, 0];
    words.extend(instruction(21, &[1, 32, 1]));
    for (id, &(name, number)) in (2u32..).zip(constants) {
        words.extend(instruction(5, &[id, u32::from(name)]));
        words.extend(instruction(71, &[id, 1, number]));
        words.extend(instruction(50, &[1, id, 7]));
    }
    words
}

#[test]
fn constants_have_names_numbers_and_types() {
    let found = interface(&module(&[(b'B', 3), (b'A', 0)])).unwrap().constants;
    let constant = |name: &str, id| Constant { name: name.to_owned(), id, kind: ConstantKind::I32 };
    assert_eq!(found, [constant("A", 0), constant("B", 3)]);
    let error = interface(&module(&[(b'A', 2), (b'B', 2)])).unwrap_err();
    assert_eq!(error, "A and B share constant_id 2");
}

#[test]
fn non_spirv_is_refused() {
    assert!(interface(&[]).is_err());
    assert!(interface(&[1, 2, 3, 4, 5, 6]).is_err());
    // The first instruction is longer than the module, and the second has the length 0.
    for head in [0x0010_0005, 0x0000_0005] {
        assert!(interface(&[0x0723_0203, 0x0001_0600, 0, 1, 0, head]).is_err());
    }
}
