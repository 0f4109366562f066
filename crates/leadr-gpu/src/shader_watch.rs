//! Watches the sources of the shaders, and compiles changed shaders in the background.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, SystemTime};

use leadr_glsl::compiler::{Compiler, collect, normal, slashes};

use super::shaders::Shader;
use super::{Gpu, GpuError, Result};

/// The interval between checks for changed files.
const INTERVAL: Duration = Duration::from_millis(250);

/// The outcome of compiling changed files.
pub enum Change {
    /// The entry points that were compiled.
    Compiled(CompiledShaders),
    /// Compilation failed. The text is the compiler's message, with file and line.
    Failed(String),
}

/// Compiled shaders that no pipeline uses yet.
pub struct CompiledShaders(Vec<&'static Shader>);

impl CompiledShaders {
    /// Compiles entry points. `names` are their paths below `root`.
    ///
    /// # Errors
    /// Returns the compiler's message.
    pub fn compile(root: &Path, names: &[String]) -> std::result::Result<Self, String> {
        let compiler = Compiler::new(root)?;
        let compile = |name: &String| compiler.compile(name).map(|code| Shader::leaked(name, &code));
        names.iter().map(compile).collect::<std::result::Result<_, String>>().map(Self)
    }

    /// Returns the names of the entry points.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.0.iter().map(|shader| shader.name)
    }
}

/// A thread that watches a folder of shaders. Dropping the value stops the thread.
pub struct ShaderWatch {
    changes: Receiver<Change>,
    stop: Arc<AtomicBool>,
}

impl Drop for ShaderWatch {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

impl ShaderWatch {
    /// Watches the folder `root`, such as `shaders-glsl`. `built` lists the entry points to watch (`Gpu::shader_names`).
    ///
    /// # Errors
    /// Returns an error if the folder has no entry points of this build.
    pub fn new(root: &Path, built: impl IntoIterator<Item = &'static str>) -> Result<Self> {
        let fault = |fault: String| GpuError::Shader { name: root.display().to_string(), fault };
        if !root.join("passes").is_dir() {
            return Err(fault("it has no folder \"passes\": choose a folder like shaders-glsl".to_owned()));
        }
        let (sender, changes) = channel();
        let (stop, root) = (Arc::new(AtomicBool::new(false)), root.to_owned());
        let stops = stop.clone();
        let built: BTreeSet<&str> = built.into_iter().collect();
        let watch = move || watch(&root, &built, &sender, &stops);
        std::thread::Builder::new().spawn(watch).map_err(|refused| GpuError::Shader {
            name: "watch".to_owned(),
            fault: format!("the system refuses another thread ({refused}): end other programs"),
        })?;
        Ok(Self { changes, stop })
    }

    /// Returns the change since the last call, if there is one.
    pub fn change(&self) -> Option<Change> {
        self.changes.try_recv().ok()
    }
}

impl Gpu {
    /// Replaces the shaders that have the same names, as `Gpu::reload` does. Returns the number of re-created pipelines.
    ///
    /// # Errors
    /// Returns an error if a shader does not fit its pipeline. All pipelines then stay unchanged.
    pub fn take_shaders(self: &Arc<Self>, shaders: CompiledShaders) -> Result<usize> {
        self.reload(shaders.0)
    }
}

/// Returns the files below `root` and their modification times.
fn written(root: &Path) -> BTreeMap<PathBuf, SystemTime> {
    let mut found = BTreeMap::new();
    let mut folders = vec![root.to_owned()];
    while let Some(folder) = folders.pop() {
        let Ok(entries) = std::fs::read_dir(&folder) else { continue };
        for entry in entries.flatten() {
            let Ok(about) = entry.metadata() else { continue };
            if about.is_dir() {
                folders.push(entry.path());
            } else if let (Ok(time), Ok(path)) = (about.modified(), entry.path().strip_prefix(root)) {
                found.insert(path.to_owned(), time);
            }
        }
    }
    found
}

/// Returns the files that `file` includes, directly or indirectly. The file is searched, but not compiled.
fn includes(root: &Path, file: &Path, known: &mut BTreeMap<PathBuf, BTreeSet<PathBuf>>) -> BTreeSet<PathBuf> {
    if let Some(found) = known.get(file) {
        return found.clone();
    }
    // This entry stops the recursion at circular includes.
    known.insert(file.to_owned(), BTreeSet::new());
    let text = std::fs::read_to_string(root.join(file)).unwrap_or_default();
    let mut all = BTreeSet::new();
    for line in text.lines() {
        let Some(rest) = line.trim_start().strip_prefix("#include") else { continue };
        let name = rest.trim().trim_matches(['"', '<', '>']);
        let beside = file.parent().map(|folder| folder.join(name));
        for candidate in beside.into_iter().chain([PathBuf::from(name)]) {
            let candidate = PathBuf::from(slashes(&normal(&candidate)));
            if root.join(&candidate).is_file() {
                all.extend(includes(root, &candidate, known));
                all.insert(candidate);
                break;
            }
        }
    }
    known.insert(file.to_owned(), all.clone());
    all
}

fn watch(root: &Path, built: &BTreeSet<&str>, changes: &Sender<Change>, stop: &AtomicBool) {
    let mut before = written(root);
    // These entry points have changed since they were last compiled.
    let mut waiting = BTreeSet::new();
    while !stop.load(Ordering::Relaxed) {
        std::thread::sleep(INTERVAL);
        let now = written(root);
        let changed: BTreeSet<&PathBuf> =
            now.iter().filter(|(path, time)| before.get(*path) != Some(time)).map(|(path, _)| path).collect();
        if changed.is_empty() {
            continue;
        }
        let mut entries = Vec::new();
        let found = collect(&root.join("passes"), &mut entries);
        let mut known = BTreeMap::new();
        let concerned = entries.iter().filter_map(|path| path.strip_prefix(root).ok()).filter(|path| {
            built.contains(slashes(path).as_str())
                && (changed.contains(&path.to_path_buf())
                    || includes(root, path, &mut known).iter().any(|included| changed.contains(included)))
        });
        waiting.extend(concerned.map(slashes));
        before = now;
        let names: Vec<String> = waiting.iter().cloned().collect();
        let change = match found.and_then(|()| CompiledShaders::compile(root, &names)) {
            Ok(shaders) if shaders.0.is_empty() => continue,
            Ok(shaders) => {
                waiting.clear();
                Change::Compiled(shaders)
            }
            Err(message) => Change::Failed(message),
        };
        if changes.send(change).is_err() {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a copy of the sources that a test may change.
    fn sources() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shaders-glsl");
        for path in written(&from).keys() {
            let to = folder.path().join(path);
            std::fs::create_dir_all(to.parent().unwrap()).unwrap();
            std::fs::copy(from.join(path), to).unwrap();
        }
        folder
    }

    fn next(watch: &ShaderWatch) -> Change {
        for _ in 0..2400 {
            if let Some(change) = watch.change() {
                return change;
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        panic!("nothing changed in two minutes");
    }

    fn change(root: &Path, file: &str, from: &str, to: &str) {
        let path = root.join(file);
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains(from), "{file} has no {from}");
        std::fs::write(&path, text.replacen(from, to, 1)).unwrap();
    }

    #[test]
    fn changed_shaders_recompile_and_faults_give_lines() {
        let folder = sources();
        let watch = ShaderWatch::new(folder.path(), leadr_shaders::SHADERS.iter().map(|shader| shader.name)).unwrap();
        std::thread::sleep(2 * INTERVAL);
        // If an included file changes, the entry points that include it are compiled.
        change(folder.path(), "passes/tonemap.glsl", "2.51", "2.52");
        let Change::Compiled(shaders) = next(&watch) else { panic!("it compiles") };
        assert_eq!(shaders.names().collect::<Vec<_>>(), ["passes/present.frag"]);
        let code = shaders.0[0].code;
        assert_ne!(
            code,
            leadr_shaders::SHADERS.iter().find(|shader| shader.name == "passes/present.frag").unwrap().code
        );
        change(folder.path(), "passes/tonemap.glsl", "2.52", "two");
        let Change::Failed(printed) = next(&watch) else { panic!("it does not compile") };
        assert!(printed.contains("tonemap.glsl:") && printed.contains("two"), "{printed}");
        // Another entry point changes meanwhile, and is compiled as soon as all changed entry points compile.
        change(folder.path(), "passes/object_depth.frag", "void main", "/* changed */ void main");
        assert!(matches!(next(&watch), Change::Failed(printed) if printed.contains("two")));
        change(folder.path(), "passes/tonemap.glsl", "two", "2.51");
        let Change::Compiled(shaders) = next(&watch) else { panic!("it compiles again") };
        assert_eq!(shaders.names().collect::<Vec<_>>(), ["passes/object_depth.frag", "passes/present.frag"]);
    }

    #[test]
    fn a_folder_without_shaders_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let printed = ShaderWatch::new(folder.path(), []).err().unwrap().to_string();
        assert!(printed.contains("shaders-glsl"), "{printed}");
    }
}
