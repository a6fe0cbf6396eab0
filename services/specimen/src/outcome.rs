//! What comes of a specimen.

/// How a run ended. Each is a result.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub enum Ending {
    /// At its end.
    Ok,
    /// Energy appeared from nowhere (F04).
    Unstable(String),
    /// A number stopped being one (F76).
    NotFinite(String),
    /// It was not for this solver.
    Refused(String),
    /// The program failed, not the physics: it did not start, panicked or died.
    Crashed(String),
    /// It took too long.
    Timeout(String),
    /// The body could not be made.
    Geometry(String),
}

/// All points at one time, in the specimen's frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// When \[s\].
    pub time: f64,
    /// Place \[m\] and colouring number of each.
    pub points: Vec<[f32; 4]>,
}

/// What came out.
#[derive(Clone, Debug, PartialEq)]
pub struct SpecimenOutcome {
    /// How it ended.
    pub ending: Ending,
    /// Time step \[s\].
    pub step: f64,
    /// Steps taken.
    pub steps: u64,
    /// Points.
    pub points: u64,
    /// Stress at which cracks grow over σ_f \[1\].
    pub strength_ratio: f64,
    /// Shares of the body that its pieces have at the end, the largest first \[1\].
    pub pieces: Vec<f64>,
    /// Times of the samples \[s\].
    pub times: Vec<f64>,
    /// A row of samples for each probe.
    pub rows: Vec<Vec<f64>>,
    /// Pictures.
    pub frames: Vec<Frame>,
}

impl SpecimenOutcome {
    /// A run that came to nothing.
    #[must_use]
    pub fn ended(ending: Ending) -> Self {
        Self {
            ending,
            step: 0.0,
            steps: 0,
            points: 0,
            strength_ratio: 1.0,
            pieces: Vec::new(),
            times: Vec::new(),
            rows: Vec::new(),
            frames: Vec::new(),
        }
    }
}
