//! A checker of markup for tests.

/// Checks that elements are closed in order, that every `&` starts an entity, and that every attribute is quoted. Returns the
/// number of elements.
pub fn well_formed(html: &str) -> Result<usize, String> {
    let html = html.strip_prefix("<!DOCTYPE html>").unwrap_or(html);
    let (mut open, mut count, mut rest) = (Vec::new(), 0, html);
    while let Some(start) = rest.find('<') {
        check_entities(&rest[..start])?;
        let end = start + rest[start..].find('>').ok_or("a tag does not end")?;
        let tag = &rest[start + 1..end];
        rest = &rest[end + 1..];
        if let Some(name) = tag.strip_prefix('/') {
            let last: Option<&str> = open.pop();
            if last != Some(name) {
                return Err(format!("</{name}> closes {last:?}"));
            }
            continue;
        }
        count += 1;
        let name = tag.split_whitespace().next().unwrap_or_default().trim_end_matches('/');
        // Quoted text may contain any character, but outside of quotes every `=` must precede a quote.
        let mut outside = tag.split('"').step_by(2);
        let closed = tag.matches('"').count() % 2 == 0;
        if !closed || outside.any(|part| part.trim_end_matches('=').contains('=')) || tag.ends_with('=') {
            return Err(format!("an attribute is not quoted: <{tag}>"));
        }
        check_entities(tag)?;
        if !tag.ends_with('/') {
            open.push(name);
        }
        if name == "style" {
            rest = &rest[rest.find("</style>").ok_or("the style does not end")?..];
        }
    }
    if open.is_empty() { Ok(count) } else { Err(format!("not closed: {open:?}")) }
}

fn check_entities(text: &str) -> Result<(), String> {
    for (at, _) in text.match_indices('&') {
        let entity = &text[at + 1..text[at..].find(';').map_or(at + 1, |end| at + end)];
        if !["amp", "lt", "gt", "quot", "#39"].contains(&entity) {
            return Err(format!("a bare & in {text:?}"));
        }
    }
    Ok(())
}

mod tests {
    use super::*;

    #[test]
    fn checker_refuses_malformed_html() {
        for broken in [
            "<p>",
            "</p>",
            "<p><b></p></b>",
            "<p>a & b</p>",
            "<p class=x>y</p>",
            "<p>&nbsp;</p>",
            "<p",
            "<p a=\"1>y</p>",
        ] {
            assert!(well_formed(broken).is_err(), "{broken}");
        }
        assert_eq!(well_formed("<p a=\"1\">x &amp; y<br/></p>"), Ok(2));
    }
}
