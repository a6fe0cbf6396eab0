//! Pixels that the drawing library draws on, with the letters of pictures.

use cullet_picture::{Picture, Typeface};
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind,
};
use std::convert::Infallible;

/// A picture to draw on.
pub(super) struct Canvas<'a> {
    picture: &'a mut Picture,
}

type Drawn = Result<(), DrawingErrorKind<Infallible>>;

impl<'a> Canvas<'a> {
    pub(super) fn on(picture: &'a mut Picture) -> Self {
        Self { picture }
    }

    /// Covers pixels of a box by as much as they lie within a shape: `depth` is how deep a pixel's
    /// centre lies in it, or less than 0 outside.
    fn cover(&mut self, span: [i32; 4], colour: BackendColor, depth: impl Fn(f64, f64) -> f64) {
        for y in span[1]..=span[3] {
            for x in span[0]..=span[2] {
                let share = (depth(f64::from(x), f64::from(y)) + 0.5).clamp(0.0, 1.0);
                self.mix((x, y), colour.mix(share));
            }
        }
    }

    fn mix(&mut self, (x, y): BackendCoord, colour: BackendColor) {
        let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y)) else { return };
        if x >= self.picture.width || y >= self.picture.height {
            return;
        }
        let at = 3 * (y * self.picture.width + x);
        let (red, green, blue) = colour.rgb;
        for (k, new) in [red, green, blue].into_iter().enumerate() {
            let old = f64::from(self.picture.rgb[at + k]);
            let mixed = old + colour.alpha.clamp(0.0, 1.0) * (f64::from(new) - old);
            self.picture.rgb[at + k] = mixed.round() as u8;
        }
    }
}

impl DrawingBackend for Canvas<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        (self.picture.width as u32, self.picture.height as u32)
    }

    fn ensure_prepared(&mut self) -> Drawn {
        Ok(())
    }

    fn present(&mut self) -> Drawn {
        Ok(())
    }

    fn draw_pixel(&mut self, point: BackendCoord, colour: BackendColor) -> Drawn {
        self.mix(point, colour);
        Ok(())
    }

    fn draw_line<S: BackendStyle>(&mut self, a: BackendCoord, b: BackendCoord, style: &S) -> Drawn {
        let reach = f64::from(style.stroke_width()) / 2.0;
        let wide = reach.ceil() as i32 + 1;
        let (low, high) = ((a.0.min(b.0), a.1.min(b.1)), (a.0.max(b.0), a.1.max(b.1)));
        let span = [low.0 - wide, low.1 - wide, high.0 + wide, high.1 + wide];
        let (u, v) = (f64::from(b.0 - a.0), f64::from(b.1 - a.1));
        let square = (u * u + v * v).max(1e-9);
        self.cover(span, style.color(), |x, y| {
            let (x, y) = (x - f64::from(a.0), y - f64::from(a.1));
            let share = ((x * u + y * v) / square).clamp(0.0, 1.0);
            let (p, q) = (x - share * u, y - share * v);
            reach - (p * p + q * q).sqrt()
        });
        Ok(())
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Drawn {
        let points: Vec<BackendCoord> = path.into_iter().collect();
        points.windows(2).try_for_each(|pair| self.draw_line(pair[0], pair[1], style))
    }

    fn draw_circle<S: BackendStyle>(
        &mut self,
        centre: BackendCoord,
        radius: u32,
        style: &S,
        fill: bool,
    ) -> Drawn {
        let (r, half) = (f64::from(radius), f64::from(style.stroke_width()) / 2.0);
        let wide = radius as i32 + half.ceil() as i32 + 1;
        let (a, b) = centre;
        self.cover([a - wide, b - wide, a + wide, b + wide], style.color(), |x, y| {
            let (x, y) = (x - f64::from(a), y - f64::from(b));
            let away = (x * x + y * y).sqrt() - r;
            if fill { -away } else { half - away.abs() }
        });
        Ok(())
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, at: BackendCoord) -> Drawn {
        let face = choose_face(style.size());
        let (width, tall) = (face.text_width(text) as i32, face.line_height() as i32);
        let anchor = style.anchor();
        let left = match anchor.h_pos {
            HPos::Left => 0,
            HPos::Right => -width,
            HPos::Center => -width / 2,
        };
        let top = match anchor.v_pos {
            VPos::Top => 0,
            VPos::Center => -tall / 2,
            VPos::Bottom => -tall,
        };
        let turn = style.transform();
        face.draw_line(text, |x, y, share| {
            let (x, y) = turn.transform(left + x as i32, top + y as i32);
            self.mix((at.0 + x, at.1 + y), style.color().mix(share));
        });
        Ok(())
    }

    fn estimate_text_size<S: BackendTextStyle>(
        &self,
        text: &str,
        style: &S,
    ) -> Result<(u32, u32), DrawingErrorKind<Infallible>> {
        let face = choose_face(style.size());
        Ok((face.text_width(text) as u32, face.line_height() as u32))
    }
}

/// The letters that are nearest to a size; a title is bold.
fn choose_face(size: f64) -> Typeface {
    if size < 18.0 {
        Typeface::SMALL
    } else if size < 22.0 {
        Typeface::of_height(20)
    } else {
        Typeface::TITLE
    }
}
