#![allow(missing_docs)]
fn main() {
    let _ = shaderc::Compiler::new().unwrap();
}
