//! Charts of error over cost, drawn as SVG and as pixels: the same marks at the same places.

mod axis;
mod canvas;

use super::frontier::{
    ChartPoint, FINEST, FrontierChart, Reading, TARGETS, doubt, measured, percent, short, shown,
    told,
};
use axis::LogAxis;
use canvas::Canvas;
use cullet_picture::Picture;
use plotters::coord::Shift;
use plotters::element::{Circle, PathElement, Rectangle, Text};
use plotters::prelude::{DrawingArea, DrawingBackend, IntoDrawingArea, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontTransform, IntoFont, RGBColor};

/// Pixels across and down.
const SIZE: (u32, u32) = (1200, 760);
/// The plot: left, top, right, bottom \[pixels\].
const PLOT: [i32; 4] = [96, 104, 800, 680];
/// Where the legend begins \[pixels\].
const LEGEND: (i32, i32) = (832, 104);
/// Heights of text \[pixels\].
const TITLE: i32 = 24;
const LABEL: i32 = 20;
const NOTE: i32 = 16;
/// Most letters of a line of notes under the title, and of a name.
const LETTERS: (usize, usize) = (140, 32);
/// Radius of a point \[pixels\].
const DOT: i32 = 5;

const INK: RGBColor = RGBColor(30, 30, 30);
const GREY: RGBColor = RGBColor(110, 110, 110);
const FAINT: RGBColor = RGBColor(225, 225, 225);
const LINE: RGBColor = RGBColor(190, 190, 190);
/// Colours that most eyes tell apart (Okabe and Ito), then some more.
const COLOURS: [RGBColor; 12] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(140, 86, 75),
    RGBColor(120, 94, 240),
    RGBColor(128, 128, 0),
    RGBColor(70, 70, 140),
    RGBColor(220, 38, 127),
    RGBColor(90, 90, 90),
];

/// A chart as SVG.
///
/// # Errors
/// What the drawing library says.
pub fn svg(chart: &FrontierChart, reading: &Reading, machine: &str) -> Result<String, String> {
    let mut text = String::new();
    draw(SVGBackend::with_string(&mut text, SIZE).into_drawing_area(), (chart, reading, machine))?;
    Ok(text)
}

/// A chart as pixels.
///
/// # Errors
/// What the drawing library says.
pub fn picture(chart: &FrontierChart, reading: &Reading, machine: &str) -> Result<Picture, String> {
    let (width, height) = (SIZE.0 as usize, SIZE.1 as usize);
    let mut picture = Picture::filled(width, height, [255; 3]);
    draw(Canvas::on(&mut picture).into_drawing_area(), (chart, reading, machine))?;
    Ok(picture)
}

fn draw<D: DrawingBackend>(
    area: DrawingArea<D, Shift>,
    (chart, reading, machine): (&FrontierChart, &Reading, &str),
) -> Result<(), String> {
    let (x, y) = axes(reading);
    let pen = Pen { area: &area, chart, reading, machine, x, y };
    pen.background()?;
    pen.grid()?;
    pen.targets()?;
    pen.frontier()?;
    for curve in 0..reading.curves.len() {
        pen.curve(curve)?;
    }
    pen.legend()?;
    pen.key()?;
    area.present().map_err(|error| error.to_string())
}

/// Axes that all points fit on: costs, and errors from below the least that counts to above 1.
fn axes(reading: &Reading) -> (LogAxis, LogAxis) {
    let costs = reading.spots.iter().map(|spot| spot.cost);
    let errors = reading.spots.iter().filter_map(|spot| spot.error);
    let least = errors.clone().map(|e| if e.1 > 0.0 { e.1 } else { e.0 });
    let low = least.filter(|e| *e > 0.0).fold(TARGETS[1], f64::min);
    let high = errors.map(|e| e.2).fold(1.0, f64::max);
    let (cheap, dear) = costs.fold((f64::INFINITY, 0.0), |(a, b), c| (c.min(a), c.max(b)));
    let (cheap, dear) = if dear > 0.0 { (cheap, dear) } else { (0.1, 10.0) };
    let [left, top, right, bottom] = PLOT;
    (
        LogAxis::new(cheap / 1.6, dear * 1.6, left, right),
        LogAxis::new(low / 1.6, high * 1.8, bottom, top),
    )
}

struct Pen<'a, D: DrawingBackend> {
    area: &'a DrawingArea<D, Shift>,
    chart: &'a FrontierChart,
    reading: &'a Reading,
    machine: &'a str,
    x: LogAxis,
    y: LogAxis,
}

/// A text: where, how high, in which colour, and how it lies about its place.
type TextPlacement = ((i32, i32), i32, RGBColor, HPos);

impl<D: DrawingBackend> Pen<'_, D> {
    fn text(&self, text: &str, (at, size, colour, side): TextPlacement) -> Result<(), String> {
        let style = ("sans-serif", size).into_font().color(&colour);
        let style = style.pos(Pos::new(side, VPos::Center));
        let text = Text::new(text.to_owned(), at, style);
        self.area.draw(&text).map_err(|error| error.to_string())
    }

    fn path(&self, points: &[(i32, i32)], colour: RGBColor, width: u32) -> Result<(), String> {
        let path = PathElement::new(points.to_vec(), colour.stroke_width(width));
        self.area.draw(&path).map_err(|error| error.to_string())
    }

    fn dot(&self, at: (i32, i32), colour: RGBColor, radius: i32) -> Result<(), String> {
        let dot = Circle::new(at, radius, colour.filled());
        self.area.draw(&dot).map_err(|error| error.to_string())
    }

    fn ring(&self, at: (i32, i32), radius: i32) -> Result<(), String> {
        let ring = Circle::new(at, radius, INK.stroke_width(2));
        self.area.draw(&ring).map_err(|error| error.to_string())
    }

    fn cross(&self, (x, y): (i32, i32), colour: RGBColor) -> Result<(), String> {
        let r = DOT + 2;
        self.path(&[(x - r, y - r), (x + r, y + r)], colour, 3)?;
        self.path(&[(x - r, y + r), (x + r, y - r)], colour, 3)
    }

    /// A diamond around a point: the default.
    fn diamond(&self, (x, y): (i32, i32)) -> Result<(), String> {
        let r = 3 * DOT;
        self.path(&[(x - r, y), (x, y - r), (x + r, y), (x, y + r), (x - r, y)], INK, 2)
    }

    fn background(&self) -> Result<(), String> {
        let (chart, left) = (self.chart, 28);
        let whole = Rectangle::new(
            [(0, 0), (SIZE.0 as i32, SIZE.1 as i32)],
            RGBColor(255, 255, 255).filled(),
        );
        self.area.draw(&whole).map_err(|error| error.to_string())?;
        let title = shortened(&format!("{}: {}", chart.name, chart.title), 88);
        self.text(&title, ((left, 30), TITLE, INK, HPos::Left))?;
        let note = shortened(&measured(chart, self.reading.seeds), LETTERS.0);
        self.text(&note, ((left, 62), NOTE, GREY, HPos::Left))
    }

    fn grid(&self) -> Result<(), String> {
        let [left, top, right, bottom] = PLOT;
        for (at, label) in self.x.lines() {
            let x = self.x.at(at);
            let colour = if label { LINE } else { FAINT };
            self.path(&[(x, bottom), (x, top)], colour, 1)?;
            if label {
                let text = format!("{at} s");
                self.text(&text, ((x, bottom + 20), LABEL, INK, HPos::Center))?;
            }
        }
        for (at, label) in self.y.lines() {
            let y = self.y.at(at);
            let colour = if label { LINE } else { FAINT };
            self.path(&[(left, y), (right, y)], colour, 1)?;
            if label {
                self.text(&percent(at), ((left - 10, y), LABEL, INK, HPos::Right))?;
            }
        }
        let frame = [(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
        self.path(&frame, INK, 1)?;
        let below = ((left + right) / 2, bottom + 52);
        let label = format!("processor time of a run, {}", shortened(self.machine, 34));
        self.text(&label, (below, LABEL, INK, HPos::Center))?;
        let style = ("sans-serif", LABEL).into_font().transform(FontTransform::Rotate270);
        let style = style.color(&INK).pos(Pos::new(HPos::Center, VPos::Center));
        let text = Text::new("error", (16, (top + bottom) / 2), style);
        self.area.draw(&text).map_err(|error| error.to_string())
    }

    /// Lines at the errors whose costs are reported.
    fn targets(&self) -> Result<(), String> {
        let [left, _, right, _] = PLOT;
        for target in TARGETS {
            let y = self.y.at(target);
            for x in (left..right - 6).step_by(12) {
                self.path(&[(x, y), (x + 6, y)], GREY, 1)?;
            }
            self.text(&percent(target), ((right - 6, y - 11), NOTE, GREY, HPos::Right))?;
        }
        Ok(())
    }

    fn place(&self, spot: &ChartPoint) -> (i32, i32) {
        let top = PLOT[1];
        (self.x.at(spot.cost), spot.error.map_or(top, |error| self.y.at(error.0)))
    }

    /// The Pareto set, as the steps that bound what can be had.
    fn frontier(&self) -> Result<(), String> {
        let spots = self.reading.pareto.iter().map(|&k| self.place(&self.reading.spots[k]));
        let mut steps: Vec<(i32, i32)> = Vec::new();
        for (x, y) in spots {
            if let Some(&(_, before)) = steps.last() {
                steps.push((x, before));
            }
            steps.push((x, y));
        }
        if let Some(&(_, y)) = steps.last() {
            steps.push((PLOT[2], y));
        }
        let pale = RGBColor(150, 150, 150);
        self.path(&steps, pale, 2)
    }

    fn colour(&self, curve: usize) -> RGBColor {
        if self.reading.curves[curve] == FINEST { INK } else { COLOURS[curve % COLOURS.len()] }
    }

    fn curve(&self, curve: usize) -> Result<(), String> {
        let colour = self.colour(curve);
        let own = || self.reading.spots.iter().enumerate().filter(|(_, s)| s.curve == curve);
        // A failed point parts the line.
        let all: Vec<&ChartPoint> = own().map(|(_, spot)| spot).collect();
        for line in all.split(|spot| spot.error.is_none()).filter(|line| line.len() > 1) {
            let line: Vec<(i32, i32)> = line.iter().map(|spot| self.place(spot)).collect();
            self.path(&line, colour, 2)?;
        }
        for (k, spot) in own() {
            let at = self.place(spot);
            let Some((_, low, high)) = spot.error else {
                self.cross(at, colour)?;
                if spot.standard {
                    self.diamond(at)?;
                }
                continue;
            };
            if high > low {
                let (a, b) = (self.y.at(low), self.y.at(high));
                self.path(&[(at.0, a), (at.0, b)], colour, 1)?;
                for y in [a, b] {
                    self.path(&[(at.0 - 4, y), (at.0 + 4, y)], colour, 1)?;
                }
            }
            self.dot(at, colour, DOT)?;
            if self.reading.pareto.contains(&k) {
                self.ring(at, DOT + 3)?;
            }
            if spot.standard {
                self.diamond(at)?;
            }
        }
        Ok(())
    }

    fn legend(&self) -> Result<(), String> {
        let (left, top) = LEGEND;
        let [ten, three] = TARGETS.map(percent);
        let head = format!("option, cost to {ten} and to {three}");
        self.text(&head, ((left, top), NOTE, GREY, HPos::Left))?;
        let count = self.reading.curves.len().max(1) as i32;
        let step = (400 / count).min(46);
        for (k, name) in self.reading.curves.iter().enumerate() {
            let y = top + 30 + step * k as i32;
            let colour = self.colour(k);
            self.path(&[(left, y), (left + 30, y)], colour, 2)?;
            self.dot((left + 15, y), colour, DOT)?;
            let label = shortened(name, LETTERS.1);
            self.text(&label, ((left + 40, y), LABEL - 4, INK, HPos::Left))?;
            let costs = self.reading.costs[k].map(told);
            if name != FINEST && step > 30 {
                let note = format!("{}; {}", costs[0], costs[1]);
                self.text(&note, ((left + 40, y + 18), NOTE, GREY, HPos::Left))?;
            }
        }
        Ok(())
    }

    /// What the marks mean, and the cheapest points that are true enough.
    fn key(&self) -> Result<(), String> {
        let (left, mut y) = (LEGEND.0, 566);
        let note = |text: &str, y: i32| self.text(text, ((left + 40, y), NOTE, INK, HPos::Left));
        self.dot((left + 15, y), GREY, DOT)?;
        self.diamond((left + 15, y))?;
        note("the default", y)?;
        y += 32;
        self.path(&[(left, y), (left + 30, y)], RGBColor(150, 150, 150), 2)?;
        self.dot((left + 15, y), GREY, DOT)?;
        self.ring((left + 15, y), DOT + 3)?;
        note("nothing is cheaper and truer", y)?;
        y += 28;
        self.cross((left + 15, y), GREY)?;
        note("failed, on the top line", y)?;
        for (target, best) in TARGETS.iter().zip(self.reading.cheapest) {
            y += 32;
            let spot = best.map(|k| &self.reading.spots[k]);
            let head = format!("cheapest within {}: ", percent(*target));
            let cost = spot
                .map_or("none".to_owned(), |s| format!("{} s{}", short(s.cost), doubt(s, *target)));
            self.text(&format!("{head}{cost}"), ((left, y), NOTE, INK, HPos::Left))?;
            if let Some(spot) = spot {
                y += 20;
                let name = format!("{}, {}", self.reading.curves[spot.curve], shown(&spot.along));
                let name = shortened(&name, 44);
                self.text(&name, ((left, y), NOTE, GREY, HPos::Left))?;
            }
        }
        Ok(())
    }
}

/// At most so many letters of a text.
fn shortened(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    text.chars().take(most.saturating_sub(3)).chain("...".chars()).collect()
}
