//! What a step noticed.

/// What a step noticed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DomainTally {
    /// Energy lost to damage \[J\].
    pub dissipated: f64,
    /// Energy that sides of cracks lost as they met \[J\].
    pub collided: f64,
    /// Energy that flow took \[J\].
    pub plastic: f64,
    /// Greatest eigenvalue of C⁻¹ of the points that flowed \[1\]: a body that is pressed flat
    /// needs smaller steps by its root.
    pub thinnest: f64,
    /// Points whose damage grew.
    pub grown: u32,
    /// Points that reached full damage.
    pub broken: u32,
    /// Of these, those that were drawn out farther than the grid follows.
    pub shredded: u32,
    /// Points with J ≤ 0.2 now (F07).
    pub crushed: u32,
    /// Greatest |v|² of a node \[m²/s²\].
    pub fastest: f64,
}

impl DomainTally {
    pub(super) fn add(mut self, other: Self) -> Self {
        self.dissipated += other.dissipated;
        self.plastic += other.plastic;
        self.collided += other.collided;
        self.thinnest = self.thinnest.max(other.thinnest);
        self.grown += other.grown;
        self.broken += other.broken;
        self.shredded += other.shredded;
        self.crushed += other.crushed;
        self.fastest = self.fastest.max(other.fastest);
        self
    }
}
