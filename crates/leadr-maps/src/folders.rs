//! Files in an untrusted folder: searches by name, and links that lead out of the folder.

use std::path::{Path, PathBuf};

use super::MapFault;

/// Maximum number of files in a folder that match a search.
pub const MAX_MATCHES: usize = 10_000;

/// Treatment of links in a folder that lead out of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OutsideLinks {
    /// A link out of the folder is an error.
    #[default]
    Refused,
    /// Links are followed, for trusted folders.
    Followed,
}

impl OutsideLinks {
    /// Follows links if `follow` is set.
    pub const fn followed(follow: bool) -> Self {
        if follow { Self::Followed } else { Self::Refused }
    }

    /// Checks a file at the path `inside` of a folder. Missing files pass, because reading reports them.
    ///
    /// # Errors
    /// Returns [`MapFault::OutsideLink`] if a link on the path leads out of the folder, and links are not followed.
    pub fn check(self, folder: &Path, inside: &Path) -> Result<(), MapFault> {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let real = |path: &Path| std::fs::canonicalize(path).ok();
        let (Some(root), Some(file)) = (real(folder), real(&folder.join(inside))) else { return Ok(()) };
        if self == Self::Followed || file.starts_with(root) {
            return Ok(());
        }
        let mut shortest_first: Vec<&Path> = inside.ancestors().collect();
        shortest_first.reverse();
        let link = shortest_first.into_iter().find(|path| folder.join(path).is_symlink()).unwrap_or(inside);
        Err(MapFault::OutsideLink { link: link.to_path_buf() })
    }
}

/// Returns the paths in a folder that `wanted` accepts, sorted. Only accepted names count, so that other files hide none.
///
/// # Errors
/// Fails if the folder cannot be read, or more than [`MAX_MATCHES`] names are accepted.
pub fn matching(folder: &Path, mut wanted: impl FnMut(&Path) -> bool) -> Result<Vec<PathBuf>, MapFault> {
    let entries = std::fs::read_dir(folder).map_err(MapFault::io("cannot be read as a folder"))?;
    let mut found = Vec::new();
    for entry in entries {
        let path = entry.map_err(MapFault::io("cannot be listed"))?.path();
        if !wanted(&path) {
            continue;
        }
        if found.len() == MAX_MATCHES {
            let what = format!("more than {MAX_MATCHES} of its files have the name of a map");
            return Err(MapFault::unsupported(what, "keep the maps of a model or a material in a folder of their own"));
        }
        found.push(path);
    }
    found.sort();
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_files_hide_no_match() {
        let folder = tempfile::tempdir().unwrap();
        let add = |name: &str| std::fs::write(folder.path().join(name), b"").unwrap();
        (0..=MAX_MATCHES).for_each(|i| add(&format!("{i}.txt")));
        add("b.png");
        add("a.png");
        let is = |wanted: &'static str| move |path: &Path| path.extension().is_some_and(|found| found == wanted);
        let found = matching(folder.path(), is("png")).unwrap();
        assert_eq!(found, ["a.png", "b.png"].map(|name| folder.path().join(name)));
        let error = matching(folder.path(), is("txt")).unwrap_err().to_string();
        assert!(error.contains("more than 10000 of its files") && error.contains("; keep the maps"), "{error}");
        assert!(matching(&folder.path().join("none"), is("png")).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn links_out_of_a_folder_are_refused_by_name() {
        use std::os::unix::fs::symlink;
        let parent = tempfile::tempdir().unwrap();
        let folder = parent.path().join("folder");
        std::fs::create_dir_all(folder.join("real")).unwrap();
        std::fs::write(parent.path().join("secret"), b"s").unwrap();
        std::fs::write(folder.join("real/map"), b"m").unwrap();
        symlink(parent.path(), folder.join("up")).unwrap();
        symlink("../secret", folder.join("out")).unwrap();
        symlink("real/map", folder.join("within")).unwrap();
        let check = |links: OutsideLinks, inside: &str| links.check(&folder, Path::new(inside));
        for inside in ["real/map", "within", "none", "up/folder/real/map"] {
            assert!(check(OutsideLinks::Refused, inside).is_ok(), "{inside}");
        }
        for (inside, link) in [("out", "out"), ("up/secret", "up")] {
            let error = check(OutsideLinks::Refused, inside).unwrap_err().to_string();
            let wanted = format!("the link {link:?} leads out of its folder; add --follow-links if you trust it");
            assert!(error.contains(&wanted), "{error}");
            assert!(check(OutsideLinks::Followed, inside).is_ok());
        }
    }
}
