//! Formatting of text and numbers for a page.

use std::fmt::Write;

use leadr_maps::shown::shown_lines;

/// Escapes text for an element or a quoted attribute, and makes invisible characters visible.
pub fn escape(text: &str) -> String {
    let text = shown_lines(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    text.replace('"', "&quot;").replace('\'', "&#39;")
}

/// Returns the relative address of a file below the page, for a quoted attribute. The `file` is a path with `/`. All bytes are
/// encoded that have a meaning in an address or in HTML, so a name such as `javascript:x#y?` stays a name.
pub fn address(file: &[u8]) -> String {
    let mut address = String::with_capacity(file.len());
    for &byte in file {
        if byte.is_ascii_alphanumeric() || b"-._~/".contains(&byte) {
            address.push(char::from(byte));
        } else {
            let _ = write!(address, "%{byte:02X}");
        }
    }
    // Two slashes at the start would name a host.
    if address.starts_with("//") { format!(".{address}") } else { address }
}

/// Formats a number with about three significant digits: `0.123`, `12.3`, `1234`, `1.23e-5`, or `–` for NaN.
pub fn number(value: f64) -> String {
    let size = value.abs();
    match size {
        _ if value.is_nan() => "–".to_owned(),
        _ if value.is_infinite() => if value > 0.0 { "∞" } else { "−∞" }.to_owned(),
        0.0 => "0".to_owned(),
        _ if !(1e-4..1e6).contains(&size) => format!("{value:.2e}"),
        _ => {
            let digits = (2 - size.log10().floor() as i32).clamp(0, 6) as usize;
            format!("{value:.digits$}")
        }
    }
}

/// Formats a fraction as a percentage, such as `12.3 %`. Positive values get a plus sign if `signed` is set.
pub fn percent(share: f64, signed: bool) -> String {
    let value = number(share * 100.0);
    let sign = if signed && share > 0.0 { "+" } else { "" };
    format!("{sign}{value} %")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_file_names() {
        for (file, expected) in [
            (&b"pictures/a-b_1.png"[..], "pictures/a-b_1.png"),
            (b"javascript:alert('1')", "javascript%3Aalert%28%271%27%29"),
            (b"a#b?c%d e\"<&.png", "a%23b%3Fc%25d%20e%22%3C%26.png"),
            ("é\u{202e}\n".as_bytes(), "%C3%A9%E2%80%AE%0A"),
            (b"\xff.png", "%FF.png"),
            (b"//host/a", ".//host/a"),
        ] {
            assert_eq!(address(file), expected);
        }
        assert_eq!(escape("\u{1b}[31m<\u{202e}"), "\\u{1b}[31m&lt;\\u{202e}");
    }

    #[test]
    fn numbers_have_three_digits() {
        let cases = [
            (0.0, "0"),
            (0.123_456, "0.123"),
            (12.345, "12.3"),
            (1234.5, "1234"),
            (0.001_234, "0.00123"),
            (1.234e-5, "1.23e-5"),
            (-0.5, "-0.500"),
            (2.5e7, "2.50e7"),
            (f64::NAN, "–"),
            (f64::INFINITY, "∞"),
        ];
        for (value, text) in cases {
            assert_eq!(number(value), text);
        }
        assert_eq!((percent(0.025, true), percent(-0.1, true), percent(0.5, false)), {
            ("+2.50 %".to_owned(), "-10.0 %".to_owned(), "50.0 %".to_owned())
        });
    }
}
