//! Letters of pictures and charts. They come ready as pictures: no font of the machine is asked, so
//! that a picture is the same everywhere.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

/// What is shown for a letter that there is no picture of.
const UNKNOWN: char = '?';

/// Letters of one size and weight; all are equally wide.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Typeface {
    height: RasterHeight,
    weight: FontWeight,
}

impl Typeface {
    /// Those of running text, from the smallest.
    const TEXT: [Self; 4] = [
        Self::regular(RasterHeight::Size16),
        Self::regular(RasterHeight::Size20),
        Self::regular(RasterHeight::Size24),
        Self::regular(RasterHeight::Size32),
    ];
    /// Those of the smallest text.
    pub const SMALL: Self = Self::TEXT[0];
    /// Those of a title.
    pub const TITLE: Self = Self { height: RasterHeight::Size24, weight: FontWeight::Bold };

    const fn regular(height: RasterHeight) -> Self {
        Self { height, weight: FontWeight::Regular }
    }

    /// The largest letters of running text whose lines are at most so high \[pixels\]; the
    /// smallest, where none are so small.
    #[must_use]
    pub fn of_height(pixels: usize) -> Self {
        let fits = |face: &&Self| face.line_height() <= pixels;
        Self::TEXT.iter().rev().find(fits).copied().unwrap_or(Self::SMALL)
    }

    /// The largest letters of running text, no larger than these, in which each of some lines is at
    /// most so wide \[pixels\]; the smallest, where there are none.
    #[must_use]
    pub fn fit_lines(self, lines: &[String], width: usize) -> Self {
        let all = Self::TEXT;
        let small = all.iter().rev().filter(|face| face.line_height() <= self.line_height());
        let fits = |face: &&Self| lines.iter().all(|line| face.text_width(line) <= width);
        small.copied().find(|face| fits(&face)).unwrap_or(Self::SMALL)
    }

    /// Height of a line \[pixels\].
    #[must_use]
    pub fn line_height(self) -> usize {
        self.height.val()
    }

    /// Width of a line \[pixels\].
    #[must_use]
    pub fn text_width(self, line: &str) -> usize {
        get_raster_width(self.weight, self.height) * line.chars().count()
    }

    /// A text as lines that are at most so wide \[pixels\], broken between words; a word that is
    /// wider stays whole.
    #[must_use]
    pub fn wrap_text(self, text: &str, width: usize) -> Vec<String> {
        let mut lines: Vec<String> = Vec::new();
        for word in text.split(' ') {
            let joined = lines.last().map_or(word.to_owned(), |line| format!("{line} {word}"));
            if lines.is_empty() || self.text_width(&joined) <= width {
                lines.pop();
                lines.push(joined);
            } else if !word.is_empty() {
                lines.push(word.to_owned());
            }
        }
        lines
    }

    /// Calls `cover` with each pixel that a line covers, counted from its upper left corner, and
    /// with the share of the pixel that is covered \[1\].
    pub fn draw_line(self, line: &str, mut cover: impl FnMut(usize, usize, f64)) {
        let advance = get_raster_width(self.weight, self.height);
        for (place, letter) in line.chars().enumerate() {
            let raster = get_raster(letter, self.weight, self.height);
            let raster = raster.or_else(|| get_raster(UNKNOWN, self.weight, self.height));
            let rows = raster.iter().flat_map(|raster| raster.rows().enumerate());
            for (y, row) in rows {
                for (x, &share) in row.iter().enumerate().filter(|(_, share)| **share > 0) {
                    cover(place * advance + x, y, f64::from(share) / 255.0);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Typeface;

    #[test]
    fn every_sign_of_a_caption_has_letters_of_its_own() {
        let drawn = |text: &str| {
            let mut dots = Vec::new();
            Typeface::SMALL.draw_line(text, |x, y, share| dots.push((x, y, share.to_bits())));
            dots
        };
        let unknown = drawn("?");
        let all = ('a'..='z').chain('A'..='Z').chain('0'..='9').chain("_=.,:/+-[]%²³·°".chars());
        for sign in all {
            let dots = drawn(&sign.to_string());
            assert!(!dots.is_empty() && dots != unknown, "{sign}");
        }
        assert_eq!(drawn("字"), unknown);
        let wide = Typeface::SMALL.text_width("ab");
        assert!(drawn("ab").iter().all(|&(x, y, _)| x < wide && y < 16));
    }

    #[test]
    fn letters_are_as_large_as_there_is_room_for_and_no_larger_than_wanted() {
        let large = Typeface::of_height(40);
        assert_eq!(
            [5, 16, 23, 24, 40].map(|h| Typeface::of_height(h).line_height()),
            [16, 16, 20, 24, 32]
        );
        let lines = ["0.1 s".to_owned(), "0.1 s  12 fragments".to_owned()];
        for face in Typeface::TEXT {
            let room = face.text_width(&lines[1]);
            assert_eq!(large.fit_lines(&lines, room), face);
            let less = large.fit_lines(&lines, room - 1);
            assert!(less.line_height() < face.line_height() || less == Typeface::SMALL);
            assert_eq!(Typeface::SMALL.fit_lines(&lines, room), Typeface::SMALL);
        }
    }

    #[test]
    fn a_long_text_is_broken_between_words_and_loses_none() {
        let text = "0.125 s  12 solved, 282 sampled, 98 % of mass";
        let face = Typeface::SMALL;
        for letters in 1..60 {
            let width = face.text_width("a") * letters;
            let lines = face.wrap_text(text, width);
            let words = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
            assert_eq!(words(&lines.join(" ")), words(text));
            assert!(lines.iter().all(|line| face.text_width(line) <= width || !line.contains(' ')));
        }
        assert_eq!(face.wrap_text(text, usize::MAX), [text]);
    }
}
