//! The colours of a quantity that spreads in a sheet: the material's own where there is none of
//! it, darker and bluer where it is wet, towards orange where it is hot.

use super::palette::Rgb;

/// A quantity that exceeds this is a temperature in K; one below is water by dry mass \[1\].
const WATER_MOST: f32 = 20.0;
/// What differs by less than this share is uniform \[1\].
const UNIFORM: f32 = 1e-4;
/// Colours of a ramp.
const STOPS: usize = 33;

/// What the hottest place is mixed towards, in Oklab.
const HOT: [f32; 3] = [0.70, 0.13, 0.15];
/// How much of the colour is left there \[1\].
const HOT_LEFT: f32 = 0.1;
/// Share of its lightness that the wettest place keeps, and the least it comes to \[1\].
const WET_LIGHTNESS: [f32; 2] = [0.54, 0.28];
/// By how much the wettest place is greener (negative) and bluer (negative), in Oklab.
const WET_TURN: [f32; 2] = [-0.015, -0.06];

/// The scale of a quantity over a run, and its colours.
#[derive(Clone, Debug, PartialEq)]
pub struct QuantityScale {
    low: f32,
    high: f32,
    stops: Vec<Rgb>,
}

impl QuantityScale {
    /// That of a quantity with these least and greatest values in the run, on a material of that
    /// colour: from 0 to the greatest; of a temperature that is far from 0, from the least. None
    /// where all of it is one, everywhere and always: the material then looks like itself.
    #[must_use]
    pub fn of(material: Rgb, (least, most): (f32, f32)) -> Option<Self> {
        let size = least.abs().max(most.abs());
        if !(most - least > UNIFORM * size && size.is_finite()) {
            return None;
        }
        let hot = most > WATER_MOST;
        let low = if hot && least > 0.5 * most { least } else { least.min(0.0) };
        let dry = oklab(material);
        let [light, green, blue] = dry;
        let [left, lowest] = WET_LIGHTNESS;
        let wet = [(left * light).max(lowest), 0.5 * green + WET_TURN[0], 0.5 * blue + WET_TURN[1]];
        let hottest = [0, 1, 2].map(|k| HOT_LEFT * dry[k] + (1.0 - HOT_LEFT) * HOT[k]);
        let end = if hot { hottest } else { wet };
        let stop = |k: usize| {
            let share = k as f32 / (STOPS - 1) as f32;
            screen([0, 1, 2].map(|c| dry[c] + (end[c] - dry[c]) * share))
        };
        let stops = (0..STOPS).map(|k| if k == 0 { material } else { stop(k) }).collect();
        Some(Self { low, high: most, stops })
    }

    /// How far a value is from the lower end of the scale to the upper \[1\].
    #[must_use]
    pub fn share(&self, value: f32) -> f32 {
        let share = (value - self.low) / (self.high - self.low);
        if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 }
    }

    /// The colour at a share of the scale.
    #[must_use]
    pub fn colour(&self, share: f32) -> Rgb {
        let place = share.clamp(0.0, 1.0) * (STOPS - 1) as f32;
        let k = (place as usize).min(STOPS - 2);
        let part = place - k as f32;
        let (from, to) = (self.stops[k], self.stops[k + 1]);
        std::array::from_fn(|c| from[c] + (to[c] - from[c]) * part)
    }
}

/// A colour of a screen as lightness, green to red and blue to yellow, in which equal steps look
/// equal (Ottosson 2020).
fn oklab(rgb: Rgb) -> [f32; 3] {
    let light =
        |c: f32| if c <= 0.040_45 { c / 12.92 } else { libm::powf((c + 0.055) / 1.055, 2.4) };
    let [r, g, b] = rgb.map(light);
    let l = libm::cbrtf(0.412_221_46 * r + 0.536_332_55 * g + 0.051_445_995 * b);
    let m = libm::cbrtf(0.211_903_5 * r + 0.680_699_5 * g + 0.107_396_96 * b);
    let s = libm::cbrtf(0.088_302_46 * r + 0.281_718_85 * g + 0.629_978_7 * b);
    [
        0.210_454_26 * l + 0.793_617_8 * m - 0.004_072_047 * s,
        1.977_998_5 * l - 2.428_592_2 * m + 0.450_593_7 * s,
        0.025_904_037 * l + 0.782_771_77 * m - 0.808_675_77 * s,
    ]
}

/// The way back.
fn screen([light, green, blue]: [f32; 3]) -> Rgb {
    let cube = |c: f32| c * c * c;
    let l = cube(light + 0.396_337_78 * green + 0.215_803_76 * blue);
    let m = cube(light - 0.105_561_346 * green - 0.063_854_17 * blue);
    let s = cube(light - 0.089_484_18 * green - 1.291_485_5 * blue);
    let linear = [
        4.076_741_7 * l - 3.307_711_6 * m + 0.230_969_94 * s,
        -1.268_438 * l + 2.609_757_4 * m - 0.341_319_38 * s,
        -0.004_196_086_3 * l - 0.703_418_6 * m + 1.707_614_7 * s,
    ];
    linear.map(|c| {
        let c = c.clamp(0.0, 1.0);
        if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * libm::powf(c, 1.0 / 2.4) - 0.055 }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAPER: Rgb = [0.93, 0.91, 0.86];

    fn apart(a: Rgb, b: Rgb) -> f32 {
        (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f32::max)
    }

    #[test]
    fn water_darkens_and_turns_blue_from_zero_on() {
        let scale = QuantityScale::of(PAPER, (0.4, 1.0)).expect("it varies");
        assert_eq!((scale.share(0.0), scale.share(0.5), scale.share(2.0)), (0.0, 0.5, 1.0));
        assert_eq!(scale.colour(0.0), PAPER);
        let ramp: Vec<Rgb> = (0..=8).map(|k| scale.colour(k as f32 / 8.0)).collect();
        for pair in ramp.windows(2) {
            let steps = [0, 1].map(|k| oklab(pair[k]));
            let [from, to] = steps;
            // Equal steps of what is seen, each darker and bluer than the one before.
            assert!((from[0] - to[0] - 0.05).abs() < 0.01, "{from:?} {to:?}");
            assert!(to[2] < from[2], "{from:?} {to:?}");
        }
        let [r, _, b] = ramp[8];
        assert!(b > r + 0.08, "{:?} is blue", ramp[8]);
    }

    #[test]
    fn heat_turns_orange_over_its_own_range() {
        let scale = QuantityScale::of(PAPER, (293.0, 333.0)).expect("it varies");
        assert_eq!((scale.share(293.0), scale.share(333.0)), (0.0, 1.0));
        let [r, g, b] = scale.colour(1.0);
        assert!(r > 0.85 && (0.4..0.7).contains(&g) && b < 0.4, "{r} {g} {b}");
        let excess = QuantityScale::of(PAPER, (0.0, 80.0)).expect("it varies");
        assert_eq!(excess.share(40.0), 0.5);
    }

    #[test]
    fn what_is_uniform_looks_like_its_material() {
        for span in [(0.0, 0.0), (0.7, 0.7), (300.0, 300.000_1), (f32::NAN, f32::NAN)] {
            assert_eq!(QuantityScale::of(PAPER, span), None, "{span:?}");
        }
    }

    #[test]
    fn colours_go_there_and_back() {
        for rgb in [PAPER, [0.2, 0.21, 0.23], [0.1, 0.5, 0.9], [1.0, 1.0, 1.0]] {
            assert!(apart(screen(oklab(rgb)), rgb) < 2e-3, "{rgb:?}");
        }
    }
}
