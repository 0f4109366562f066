//! Compares Khronos' test files for the glTF validator with the errors that the validator reported. Strict loading agrees with the
//! validator, and other loading repairs what it can.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use crate::samples::models_under;
use leadr_models::{LoadOptions, Model};
use leadr_testing::memory::unmeasured;
use leadr_testing::shared::shared_data;

/// Returns the validator's error codes for a file.
fn reported(path: &Path) -> BTreeSet<String> {
    let report = path.with_file_name(format!("{}.report.json", path.file_name().unwrap().to_str().unwrap()));
    let report: serde_json::Value = serde_json::from_slice(&fs::read(report).unwrap()).unwrap();
    let messages = report["issues"]["messages"].as_array().unwrap();
    let errors = messages.iter().filter(|message| message["severity"] == 0);
    errors.map(|message| message["code"].as_str().unwrap().to_owned()).collect()
}

/// Errors for which the file can still be read correctly, each with a reason.
const HARMLESS: [(&str, &str); 30] = [
    ("ACCESSOR_ELEMENT_OUT_OF_MAX_BOUND", "declared bounds are not used"),
    ("ACCESSOR_ELEMENT_OUT_OF_MIN_BOUND", "declared bounds are not used"),
    ("ACCESSOR_MAX_MISMATCH", "declared bounds are not used"),
    ("ACCESSOR_MIN_MISMATCH", "declared bounds are not used"),
    ("ANIMATION_SAMPLER_INPUT_ACCESSOR_WITHOUT_BOUNDS", "declared bounds are not used"),
    ("MESH_PRIMITIVE_POSITION_ACCESSOR_WITHOUT_BOUNDS", "declared bounds are not used"),
    ("EMPTY_ENTITY", "an empty list equals a missing one"),
    ("ACCESSOR_NORMALIZED_INVALID", "the flag has no effect on floats"),
    ("ACCESSOR_INVALID_FLOAT", "nothing reads this accessor"),
    ("BUFFER_DATA_URI_MIME_TYPE_INVALID", "the media type of a buffer is not used"),
    ("BUFFER_MISSING_GLB_DATA", "nothing reads this buffer"),
    ("BUFFER_VIEW_TOO_BIG_BYTE_STRIDE", "the only element fits"),
    ("BUFFER_VIEW_INVALID_BYTE_STRIDE", "strides are valid for any use"),
    ("GLB_CHUNK_LENGTH_UNALIGNED", "alignment is not required"),
    ("ONE_OF_MISMATCH", "no texture uses this image"),
    ("INVALID_URI", "no texture uses this image"),
    ("IMAGE_MIME_TYPE_INVALID", "no texture uses this image"),
    ("IMAGE_DATA_INVALID", "no texture uses this image"),
    ("IMAGE_UNEXPECTED_EOS", "no texture uses this image"),
    ("IO_ERROR", "no texture uses this image"),
    ("MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_UNSIGNED_INT", "custom attributes are not read"),
    ("MESH_PRIMITIVE_INVALID_ATTRIBUTE", "custom attributes are not read"),
    ("MESH_PRIMITIVE_INDEXED_SEMANTIC_CONTINUITY", "custom attributes are not read"),
    ("MESH_PRIMITIVE_MORPH_TARGET_NO_BASE_ACCESSOR", "ignored with a remark"),
    ("ACCESSOR_INDEX_PRIMITIVE_RESTART", "primitive restart is not supported, so the index is valid"),
    ("UNSATISFIED_DEPENDENCY", "a skin or weights without a mesh are ignored with a remark"),
    ("DUPLICATE_ELEMENTS", "duplicates have no effect"),
    ("IMAGE_BUFFER_VIEW_WITH_BYTESTRIDE", "no texture uses this image"),
    ("SKIN_NO_COMMON_ROOT", "joint transforms need no common root"),
    ("SKIN_SKELETON_INVALID", "joint transforms need no common root"),
];

/// Files that are accepted despite other validator errors, each with a reason.
const HARMLESS_FILES: [(&str, &str); 3] = [
    ("mesh_data/joints_weights_complex.gltf", "only points, which are not drawn"),
    ("root/extensions_non_objects.gltf", "unsupported extensions"),
    ("root/extensions_undeclared_wrong_pointer.gltf", "unsupported extensions"),
];

/// Valid files that are refused, each with a reason.
const REFUSED_FILES: [(&str, &str); 13] = [
    ("json/integer_written_as_float.gltf", "accessors without data: all normals are 0"),
    ("mesh/primitive_generated_tangent_space.gltf", "accessors without data: all normals are 0"),
    ("node/node_skinned_mesh_without_skin.gltf", "accessors without data: all weights are 0"),
    ("node/valid.gltf", "accessors without data: all weights are 0"),
    ("skin/ignored_local_transform.gltf", "accessors without data: all weights are 0"),
    ("skin/ignored_parent_transform.gltf", "accessors without data: all weights are 0"),
    ("animation/valid.gltf", "accessors without data: all times are 0"),
    ("asset/min_version_valid.gltf", "requires glTF 2.1"),
    ("root/named_objects.gltf", "vertices in a buffer without data"),
    ("root/unused_objects.gltf", "vertices in a buffer without data"),
    ("buffer/non_relative_uri.gltf", "files outside the folder are not read"),
    ("skin/ignored_animated_transform.gltf", "accessors without data: all times are 0"),
    ("skin/valid.gltf", "accessors without data: inverse bind matrices of zeros"),
];

fn reason<'a>(table: &'a [(&str, &'a str)], key: &str) -> Option<&'a str> {
    table.iter().find(|(known, _)| key.ends_with(known)).map(|(_, reason)| *reason)
}

#[test]
fn verdicts_agree_with_the_validator() {
    let _unmeasured = unmeasured();
    let Some(folder) = shared_data("bad-input/gltf-validator") else { return };
    let mut used = BTreeSet::new();
    let mut wrong = Vec::new();
    let (mut both_accept, mut both_refuse, mut accepted, mut refused) = (0, 0, 0, 0);
    for path in models_under(&folder) {
        let errors = reported(&path);
        let short = path.strip_prefix(&folder).unwrap().display().to_string();
        let strict = LoadOptions { strict: true, ..LoadOptions::default() };
        match (Model::load(&path, strict), errors.is_empty()) {
            (Ok(_), true) => both_accept += 1,
            (Err(error), false) => {
                both_refuse += 1;
                println!(
                    "both refuse   {short}: {} [{}]",
                    error.fault,
                    errors.into_iter().collect::<Vec<_>>().join(" ")
                );
            }
            (Ok(_), false) => {
                accepted += 1;
                if let Some(reason) = reason(&HARMLESS_FILES, &short) {
                    println!("accepted      {short}: {reason}");
                    used.insert(reason);
                    continue;
                }
                for code in errors {
                    match HARMLESS.iter().find(|(known, _)| *known == code) {
                        Some((code, reason)) => {
                            println!("accepted      {short}: {code}: {reason}");
                            used.insert(*code);
                        }
                        None => wrong.push(format!("{short} was accepted despite {code}")),
                    }
                }
            }
            (Err(error), true) => {
                refused += 1;
                match reason(&REFUSED_FILES, &short) {
                    Some(reason) => println!("refused       {short}: {reason}"),
                    None => wrong.push(format!("{short} is valid, but was refused: {}", error.fault)),
                }
            }
        }
    }
    println!("accepted by both {both_accept}, refused by both {both_refuse}");
    println!("accepted here alone {accepted}, refused here alone {refused}, each for a reason");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(both_accept > 50 && both_refuse > 130, "too few files were read");
    assert_eq!(refused, REFUSED_FILES.len());
    // Every reason must be used, because an unused one would hide the next mistake.
    let stale: Vec<_> = HARMLESS.iter().filter(|(code, _)| !used.contains(code)).collect();
    assert!(stale.is_empty(), "{stale:?}");
    let stale: Vec<_> = HARMLESS_FILES.iter().filter(|(_, reason)| !used.contains(reason)).collect();
    assert!(stale.is_empty(), "{stale:?}");
}

/// Files that strict loading refuses load with a remark, or are refused because nothing can be read.
#[test]
fn files_with_errors_are_repaired_with_a_remark() {
    let _unmeasured = unmeasured();
    let Some(folder) = shared_data("bad-input/gltf-validator") else { return };
    let (mut repaired, mut refused, mut silent) = (0, 0, Vec::new());
    for path in models_under(&folder) {
        let strict = LoadOptions { strict: true, ..LoadOptions::default() };
        let short = path.strip_prefix(&folder).unwrap().display().to_string();
        let Err(error) = Model::load(&path, strict) else { continue };
        match Model::load(&path, LoadOptions::default()) {
            Ok(model) if model.remarks.is_empty() => silent.push(format!("{short}: {}", error.fault)),
            Ok(model) => {
                repaired += 1;
                println!("repaired {short}: {}", model.remarks.join(" | "));
            }
            Err(error) => {
                refused += 1;
                println!("refused  {short}: {}", error.fault);
            }
        }
    }
    println!("{repaired} repaired, {refused} refused, {} with faults in unused parts", silent.len());
    println!("{}", silent.join("\n"));
    assert!(repaired > 60 && refused < 45, "{repaired} repaired, {refused} refused");
}
