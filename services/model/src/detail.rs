//! How crack faces look closer than the grid resolves: chevrons along the way the crack ran, ribs
//! across it, grain. Thesis 3.7 (Algorithm 4, Table 3.2) with F35's corrections; all lengths in
//! grid spacings h, so a look costs the same on every body.

/// The seven numbers of the thesis's Table 3.2 and four of our own. `height`, `ribs` and `grain`
/// of zero are no detail at all, at no cost.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct CrackFaceDetail {
    /// d: longest edge of a crack face, and the step along a chevron line \[h\].
    pub edge: f64,
    /// `l_c`: longest chevron line \[h\].
    pub length: f64,
    /// s: radius within which a chevron line keeps others away \[h\].
    pub influence: f64,
    /// `h_c`: spacing of the detail grid, over which damage time and heights are smoothed \[h\].
    pub grid: f64,
    /// G: height of chevrons \[h\].
    pub height: f64,
    /// m: share of the chevron lines, longest first, that grow along their way.
    pub share: f64,
    /// Height of ribs (Wallner lines): where the front was at equal times \[h\].
    pub ribs: f64,
    /// Distance between ribs \[h\].
    pub rib_spacing: f64,
    /// Height of grain: seeded noise \[h\].
    pub grain: f64,
    /// Size of the coarsest grain; each finer octave is half as large and half as high \[h\].
    pub grain_size: f64,
}

impl Default for CrackFaceDetail {
    fn default() -> Self {
        Self::NONE
    }
}

/// A value of [`CrackFaceDetail`], its name, and its bounds.
pub type DetailBound = (&'static str, f64, f64, f64);

impl CrackFaceDetail {
    /// Faces as the grid resolves them.
    pub const NONE: Self = Self {
        edge: 0.4,
        length: 10.0,
        influence: 0.5,
        grid: 0.8,
        height: 0.0,
        share: 0.5,
        ribs: 0.0,
        rib_spacing: 3.0,
        grain: 0.0,
        grain_size: 2.0,
    };

    /// Whether faces stay as they are.
    #[must_use]
    pub fn is_none(&self) -> bool {
        self.height == 0.0 && self.ribs == 0.0 && self.grain == 0.0
    }

    /// Every value with its name, least and greatest.
    #[must_use]
    pub fn bounds(&self) -> [DetailBound; 10] {
        [
            ("edge", self.edge, 0.1, 2.0),
            ("length", self.length, 0.5, 100.0),
            ("influence", self.influence, 0.1, 10.0),
            ("grid", self.grid, 0.3, 4.0),
            ("height", self.height, 0.0, 0.5),
            ("share", self.share, 0.0, 1.0),
            ("ribs", self.ribs, 0.0, 0.5),
            ("rib_spacing", self.rib_spacing, 0.5, 100.0),
            ("grain", self.grain, 0.0, 0.5),
            ("grain_size", self.grain_size, 0.2, 20.0),
        ]
    }

    /// The first value that is out of its bounds.
    #[must_use]
    pub fn wrong(&self) -> Option<DetailBound> {
        self.bounds().into_iter().find(|&(_, value, least, most)| !(least..=most).contains(&value))
    }
}
