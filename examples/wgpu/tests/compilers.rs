//! Compiles every file of the include library by itself with third-party compilers.

use std::path::{Path, PathBuf};
use std::process::Command;

// This crate provides the archives that are linked.
use leadr_shaderc_debian as _;
use leadr_wgpu::includes::expand;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shaders-glsl")
}

/// Returns the files of the library.
fn library() -> Vec<PathBuf> {
    let mut folders = vec![root().join("leadr")];
    let mut files = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() { folders.push(path) } else { files.push(path) }
        }
    }
    files.sort();
    assert!(files.len() > 40, "{files:?}");
    files
}

/// Returns a fragment shader that includes a library file without using it.
fn shader(version: &str, library: &str) -> String {
    let precision = if version.ends_with("es") { "precision highp float;\nprecision highp int;\n" } else { "" };
    // The includer must define these macros, which access measured materials and energies.
    let includer = "#define LEADR_FITTED_WORD(i) float(i)\n#define LEADR_ENERGY_TEXEL(x, y) vec2(float(x), float(y))\n";
    format!(
        "#version {version}\n{precision}{includer}{library}\nout vec4 color;\nvoid main() {{ color = vec4(1.0); }}\n"
    )
}

/// Checks that a compiler accepts every library file and rejects invalid GLSL.
fn all_compile(compile: impl Fn(&str) -> Result<(), String>) {
    assert!(compile("float f(float x) { return x + vec2(1.0); }").is_err(), "this compiler accepts anything");
    let fault = |file: &PathBuf| {
        let text = expand(&root(), file).unwrap();
        compile(&text).err().map(|error| format!("{}: {error}", file.display()))
    };
    let faults: Vec<String> = library().iter().filter_map(fault).collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

fn shaderc(version: &str, target: shaderc::TargetEnv, environment: shaderc::EnvVersion) {
    let compiler = shaderc::Compiler::new().unwrap();
    let mut options = shaderc::CompileOptions::new().unwrap();
    options.set_target_env(target, environment as u32);
    options.set_auto_map_locations(true);
    all_compile(|library| {
        let text = shader(version, library);
        let compiled = compiler.compile_into_spirv(&text, shaderc::ShaderKind::Fragment, "a", "main", Some(&options));
        compiled.map(|_| ()).map_err(|error| error.to_string())
    });
}

#[test]
fn glslang_for_vulkan() {
    shaderc("450", shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_0);
    shaderc("460", shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_3);
}

#[test]
fn glslang_for_opengl() {
    shaderc("450", shaderc::TargetEnv::OpenGL, shaderc::EnvVersion::OpenGL4_5);
    shaderc("330", shaderc::TargetEnv::OpenGL, shaderc::EnvVersion::OpenGL4_5);
    shaderc("310 es", shaderc::TargetEnv::OpenGL, shaderc::EnvVersion::OpenGL4_5);
}

/// For these versions there is no SPIR-V. glslang's own program checks them like a driver.
#[test]
fn glslang_as_a_driver_of_opengl() {
    let folder = tempfile::tempdir().unwrap();
    for version in ["330", "300 es", "310 es", "320 es", "450"] {
        all_compile(|library| {
            let file = folder.path().join("a.frag");
            std::fs::write(&file, shader(version, library)).unwrap();
            let output = Command::new("glslangValidator").arg(&file).output();
            let output = output.expect("glslangValidator runs; scripts/setup installs it (Debian: glslang-tools)");
            if output.status.success() { Ok(()) } else { Err(String::from_utf8_lossy(&output.stdout).into_owned()) }
        });
    }
}

#[test]
fn naga() {
    all_compile(|library| {
        let text = shader("450", library).replace("\nout vec4 color;", "\nlayout(location = 0) out vec4 color;");
        let mut frontend = naga::front::glsl::Frontend::default();
        let options = naga::front::glsl::Options::from(naga::ShaderStage::Fragment);
        let module = frontend.parse(&options, &text).map_err(|error| format!("{error:?}"))?;
        let flags = naga::valid::ValidationFlags::all();
        let mut validator = naga::valid::Validator::new(flags, naga::valid::Capabilities::empty());
        let info = validator.validate(&module).map_err(|error| format!("{error:?}"))?;
        // The compiler must also be able to write the module in WGSL.
        let written = naga::back::wgsl::write_string(&module, &info, naga::back::wgsl::WriterFlags::empty());
        written.map(|_| ()).map_err(|error| format!("{error:?}"))
    });
}

#[test]
fn a_missing_include_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.glsl");
    std::fs::write(&file, "#include \"leadr/nothing.glsl\"\n").unwrap();
    let error = expand(&root(), &file).unwrap_err();
    assert!(error.contains("nothing.glsl") && error.contains("a.glsl"), "{error}");
}
