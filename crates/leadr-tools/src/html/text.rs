//! Formatting of text and numbers for a page.

/// Escapes text for an element or a quoted attribute.
pub fn escape(text: &str) -> String {
    let text = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    text.replace('"', "&quot;").replace('\'', "&#39;")
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

/// Formats a fraction as percent, such as `12.3 %`, with a plus sign for positive values if `signed`.
pub fn percent(share: f64, signed: bool) -> String {
    let value = number(share * 100.0);
    let sign = if signed && share > 0.0 { "+" } else { "" };
    format!("{sign}{value} %")
}

#[cfg(test)]
mod tests {
    use super::*;

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
