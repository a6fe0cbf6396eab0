//! A picture, its captions, and PNG files of it.

use super::letters::Typeface;
use cullet_files::output::write_file;
use cullet_record::RecordError;
use std::path::Path;

/// Red, green and blue bytes, rows from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Pixels a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Three bytes a pixel.
    pub rgb: Vec<u8>,
}

impl Picture {
    /// A picture of one colour.
    #[must_use]
    pub fn filled(width: usize, height: usize, colour: [u8; 3]) -> Self {
        Self { width, height, rgb: colour.repeat(width * height) }
    }

    /// Sets a pixel; one outside is left alone.
    pub(super) fn set(&mut self, x: usize, y: usize, colour: [u8; 3]) {
        if x < self.width && y < self.height {
            let at = 3 * (y * self.width + x);
            self.rgb[at..at + 3].copy_from_slice(&colour);
        }
    }

    /// Copies another picture into this one.
    pub(super) fn paste(&mut self, other: &Self, left: usize, top: usize) {
        for y in 0..other.height.min(self.height.saturating_sub(top)) {
            let n = other.width.min(self.width.saturating_sub(left));
            let from = 3 * y * other.width;
            let to = 3 * ((y + top) * self.width + left);
            self.rgb[to..to + 3 * n].copy_from_slice(&other.rgb[from..from + 3 * n]);
        }
    }

    /// Mixes a colour into a pixel, by a share \[1\]; one outside is left alone.
    fn mix(&mut self, (x, y): (usize, usize), colour: [u8; 3], share: f64) {
        if x < self.width && y < self.height {
            let at = 3 * (y * self.width + x);
            for (old, new) in self.rgb[at..at + 3].iter_mut().zip(colour) {
                *old = (f64::from(*old) + share * (f64::from(new) - f64::from(*old))).round() as u8;
            }
        }
    }

    /// Letters for captions of so many pictures of this width, no larger than wanted: the largest
    /// in which each caption is one line.
    pub(super) fn choose_face(largest: usize, captions: &[String], width: usize) -> Typeface {
        let largest = Typeface::of_height(largest);
        largest.fit_lines(captions, width.saturating_sub(2 * choose_margin(largest)))
    }

    /// Writes a caption in the lower left corner on a darkened strip, in as many lines as it takes.
    pub(super) fn caption(&mut self, text: &str, face: Typeface) {
        let margin = choose_margin(face);
        let lines = face.wrap_text(text, self.width.saturating_sub(2 * margin));
        let strip = face.line_height() * lines.len() + margin;
        let top = self.height.saturating_sub(strip);
        let longest = lines.iter().map(|line| face.text_width(line)).max().unwrap_or(0);
        let end = (longest + 2 * margin).min(self.width);
        for y in top..self.height {
            for x in 0..end {
                let at = 3 * (y * self.width + x);
                self.rgb[at..at + 3].iter_mut().for_each(|c| *c = (u16::from(*c) * 2 / 5) as u8);
            }
        }
        for (k, line) in lines.iter().enumerate() {
            let place = (margin, top + margin / 2 + k * face.line_height());
            self.write(line, face, place, [245, 245, 240]);
        }
    }

    /// Writes a line whose upper left corner is there.
    pub(super) fn write(
        &mut self,
        line: &str,
        face: Typeface,
        (left, top): (usize, usize),
        colour: [u8; 3],
    ) {
        face.draw_line(line, |x, y, share| self.mix((left + x, top + y), colour, share));
    }

    /// Writes a PNG file: first beside its name, then under it.
    ///
    /// # Errors
    /// The file cannot be written; nothing is left of it then.
    pub fn save(&self, path: &Path) -> Result<(), RecordError> {
        let fail = |error: png::EncodingError| RecordError::Picture {
            path: path.to_owned(),
            reason: error.to_string(),
        };
        let mut bytes = Vec::new();
        let size = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        let mut encoder = png::Encoder::new(&mut bytes, size(self.width), size(self.height));
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header().map_err(fail)?;
        writer.write_image_data(&self.rgb).map_err(fail)?;
        writer.finish().map_err(fail)?;
        write_file(path, &bytes).map_err(RecordError::io(path))
    }
}

/// What is left free around a caption \[pixels\].
fn choose_margin(face: Typeface) -> usize {
    face.line_height() / 4
}
