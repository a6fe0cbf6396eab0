//! The page itself: style, script and data in one file.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;
use serde::Serialize;
use std::io::Write;

const STYLE: &str = include_str!("../assets/style.css");
const VIEWER: &str = include_str!("../assets/viewer.js");
const LICENCE: &str = include_str!("../assets/viewer.js.LICENSE.txt");

/// Bytes as base64 text.
pub(crate) fn base64(bytes: &[u8]) -> String {
    STANDARD.encode(bytes)
}

/// Bytes compressed by gzip, as base64 text.
pub(crate) fn packed(bytes: &[u8]) -> std::io::Result<String> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes)?;
    Ok(base64(&encoder.finish()?))
}

/// Text as it stands in the page.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// JSON that may stand inside a script element: no text in it ends the element.
fn inline(data: &impl Serialize) -> serde_json::Result<String> {
    Ok(serde_json::to_string(data)?.replace('<', "\\u003c"))
}

/// Puts a page together. `body`: what is between header and scripts; `model`: the compressed GLB.
pub(crate) fn page(
    title: &str,
    body: &str,
    data: &impl Serialize,
    model: Option<&str>,
) -> serde_json::Result<String> {
    let model = model.map_or_else(String::new, |text| {
        format!("<script type=\"text/plain\" id=\"model\">{text}</script>\n")
    });
    // The bundle has no "</script" in it: a test holds that.
    Ok(format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <link rel=\"icon\" href=\"data:,\">\n\
         <title>{title} – Cullet</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <header><h1 id=\"title\">{title}</h1><p id=\"what\"></p></header>\n\
         <p id=\"fault\" role=\"alert\" hidden></p>\n{body}\
         <script type=\"application/json\" id=\"report\">{data}</script>\n{model}\
         <!--\n{LICENCE}-->\n<script>\n{VIEWER}</script>\n</body>\n</html>\n",
        title = escaped(title),
        data = inline(data)?,
    ))
}

#[cfg(test)]
mod tests {
    use super::{LICENCE, VIEWER, inline, packed, page};
    use base64::Engine;
    use std::io::Read;

    #[test]
    fn no_text_of_a_run_ends_the_script_that_holds_it() {
        let text = inline(&"</script><!-- & \u{2028}").expect("text");
        assert!(!text.contains('<'), "{text}");
        let back: String = serde_json::from_str(&text).expect("JSON");
        assert_eq!(back, "</script><!-- & \u{2028}");
        let page = page("a <b> & c", "", &"x", None).expect("a page");
        assert!(page.contains("<h1 id=\"title\">a &lt;b&gt; &amp; c</h1>"));
    }

    #[test]
    fn the_bundle_can_stand_in_a_page_and_names_its_licence() {
        assert!(!VIEWER.to_lowercase().contains("</script"));
        assert!(!VIEWER.contains("<!--"));
        assert!(LICENCE.contains("MIT") && LICENCE.contains("three.js"));
        assert!(!LICENCE.contains("--"), "it stands in a comment");
    }

    #[test]
    fn what_is_packed_unpacks() {
        let bytes: Vec<u8> = (0..10_000u32).map(|k| (k % 251) as u8).collect();
        let text = packed(&bytes).expect("packs");
        let zipped = base64::engine::general_purpose::STANDARD.decode(text).expect("base64");
        let mut back = Vec::new();
        flate2::read::GzDecoder::new(&zipped[..]).read_to_end(&mut back).expect("gzip");
        assert_eq!(back, bytes);
    }
}
