//! Text of foreign origin for terminals, logs, pages and windows: file names, strings inside files, environment variables,
//! values of the command line, names of devices, messages of drivers.
//!
//! Characters that a reader cannot see (control characters, escape sequences, text direction, zero width) become `\u{1b}`, so that
//! the text can neither command a terminal nor imitate other lines. Files and JSON keep the exact text.

use std::path::Path;

/// Maximum number of characters of a string inside a file.
const LONGEST: usize = 100;
/// Maximum number of characters of a line. Paths have at most 4096 bytes.
const LONGEST_LINE: usize = 8192;

/// Returns a string of a file for one line of text, shortened to 100 characters.
pub fn shown(text: &str) -> String {
    visible(text, LONGEST)
}

/// Returns a sentence with foreign parts as one line.
pub fn shown_line(text: &str) -> String {
    visible(text, LONGEST_LINE)
}

/// Returns a text with foreign parts, keeping its line breaks.
pub fn shown_lines(text: &str) -> String {
    text.split('\n').map(shown_line).collect::<Vec<_>>().join("\n")
}

/// Returns a path for one line of text. Bytes that are not UTF-8 become `\xff`.
pub fn shown_path(path: impl AsRef<Path>) -> String {
    let mut shown = String::new();
    for chunk in path.as_ref().as_os_str().as_encoded_bytes().utf8_chunks() {
        shown += &shown_line(chunk.valid());
        shown.extend(chunk.invalid().iter().map(|byte| format!("\\x{byte:02x}")));
    }
    shown
}

/// Returns a JSON text of the same value without invisible characters; serialisers escape only those below U+0020.
pub fn shown_json(json: &str) -> String {
    let mut shown = String::with_capacity(json.len());
    for c in json.chars() {
        if c == '\n' || is_visible(c) {
            shown.push(c);
        } else {
            shown.extend(c.encode_utf16(&mut [0; 2]).iter().map(|unit| format!("\\u{unit:04x}")));
        }
    }
    shown
}

fn visible(text: &str, longest: usize) -> String {
    let mut shown = String::with_capacity(text.len().min(longest));
    let mut push = |c: char| if is_visible(c) { shown.push(c) } else { shown.extend(c.escape_default()) };
    let count = text.chars().count();
    if count <= longest {
        text.chars().for_each(push);
    } else {
        // The end of a sentence is its remedy.
        let end = longest / 4;
        text.chars().take(longest - 1 - end).for_each(&mut push);
        push('…');
        text.chars().skip(count - end).for_each(push);
    }
    shown
}

fn is_visible(c: char) -> bool {
    match c {
        ' '..='~' => true,
        // Letters without width or ink, which Unicode does not count as format characters.
        '\u{34f}' | '\u{115f}' | '\u{1160}' | '\u{17b4}' | '\u{17b5}' | '\u{180b}'..='\u{180f}' | '\u{3164}' => false,
        '\u{fe00}'..='\u{fe0f}' | '\u{ffa0}' | '\u{e0100}'..='\u{e01ef}' => false,
        // The standard library escapes controls, formats and unassigned characters, but marks only at the start of a text.
        _ => ['a', c].iter().collect::<String>().escape_debug().nth(1) == Some(c),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invisible_characters_are_escaped() {
        for (text, expected) in [
            ("plain 'a' \"b\" \\ <c>", "plain 'a' \"b\" \\ <c>"),
            ("Grün 岩石 e\u{301} ΔE₀₀ −‖n̄‖ …", "Grün 岩石 e\u{301} ΔE₀₀ −‖n̄‖ …"),
            ("\u{1b}]0;x\u{7}", "\\u{1b}]0;x\\u{7}"),
            ("\u{9b}2J\u{7f}\0", "\\u{9b}2J\\u{7f}\\u{0}"),
            ("a\nb\r\tc", "a\\nb\\r\\tc"),
            ("\u{202e}gpj\u{2066}", "\\u{202e}gpj\\u{2066}"),
            ("\u{200b}\u{feff}\u{2028}\u{ad}", "\\u{200b}\\u{feff}\\u{2028}\\u{ad}"),
            ("\u{e0041}\u{fe0f}\u{3164}", "\\u{e0041}\\u{fe0f}\\u{3164}"),
        ] {
            assert_eq!(shown(text), expected);
            assert_eq!(shown(expected), expected, "twice is as good as once");
        }
        assert_eq!(shown_lines("a\n\u{1b}b\n"), "a\n\\u{1b}b\n");
    }

    #[test]
    fn long_text_keeps_both_ends() {
        let text = format!("begin{}end", "x".repeat(100_000));
        let name = shown(&text);
        assert_eq!(name.chars().count(), LONGEST);
        assert!(name.starts_with("beginx") && name.contains("x…x") && name.ends_with("xend"), "{name}");
        assert!(shown_line(&text).ends_with("end") && shown_line(&text).len() < 9000);
        assert_eq!(shown(&"é".repeat(LONGEST)), "é".repeat(LONGEST));
    }

    #[cfg(unix)]
    #[test]
    fn paths_show_bytes_that_are_no_text() {
        use std::ffi::OsStr;
        use std::os::unix::ffi::OsStrExt;
        assert_eq!(shown_path(OsStr::from_bytes(b"a\xff\x1b\xc3\xa9\xc3")), "a\\xff\\u{1b}é\\xc3");
    }

    #[test]
    fn json_keeps_its_value() {
        let text = "a\u{9b}\u{202e}\u{e0041}\u{1b}é\n";
        let json = shown_json(&serde_json::to_string_pretty(&[text]).unwrap());
        assert!(json.chars().all(|c| c == '\n' || is_visible(c)), "{json}");
        assert_eq!(serde_json::from_str::<Vec<String>>(&json).unwrap(), [text]);
    }
}
