//! The peridynamic family: solids as points and bonds between those within a horizon δ (Chen, Zhu,
//! Zhao, Li and Wang 2018), state-based: what a bond bears depends on all bonds of its points.
//!
//! With ξ a bond at rest, l₀ = |ξ|, λ its length over l₀ and q = λ − 1, a point with the weights w
//! of its bonds, Σw = 1, has
//! - the mean extension q̄ = Σwq and the dilatation θ = 3q̄,
//! - of each bond the deviatoric extension z = q − q̄ − e_p, e_p being what has flowed,
//! - the energy density ½Kθ² + 15/2 μ Σwz² and the equivalent stress σ_eq = μ√(45 Σwz²).
//!
//! The weights are fitted so that Σw n⊗n⊗n⊗n is the isotropic tensor: then this is Hooke's law and
//! von Mises' at small strains, at faces too, but not at edges and corners ([`bonds`]). Other
//! tensors make it stiffer in some directions ([`anisotropy`]). In place of the paper's law of each
//! bond, which yields too late and flows under pressure, a point yields as a whole ([`law`]).
//!
//! Bonds soften and break by their elastic stretch, so that a plane costs G_f, or by flow. What is
//! left of a bond, k, weighs it in all sums, and the mean is that of q − e_p over Σwk. Points that
//! have lost bonds touch and rub; those that have none left fly by themselves.
//!
//! Two passes over all bonds make a step ([`domain`]): the first softens them and sums them up for
//! each point, the second finds what has flowed and the forces. Both are worked out in f32, from
//! displacements that are counted from where the body as a whole is; places and velocities are f64.
//! A part that has moved by u from there has an error of strain of up to 1e-7 |u|/δ.
//!
//! It holds for small strains, elastic and plastic: extensions are linear, so that what flows loses
//! volume, 1 % at a plastic strain of 0.1. [`PeridynamicDomain::check`] refuses what is beyond.
//!
//! [`specimen`] puts benchmark specimens as points and bonds.
//!
//! [`solver`] is the family: rigid strikers and supports press on a body, which is dented, or falls
//! into the parts that bonds still hold together. [`soft`] is the family of soft solids, which move
//! for as long as a scene lasts.

pub mod anisotropy;
pub mod bonds;
pub mod domain;
mod frame;
mod kernel;
pub mod law;
pub mod soft;
pub mod solver;
pub mod specimen;

pub use bonds::BondGraph;
pub use domain::PeridynamicDomain;
pub use law::PeridynamicLaw;
pub use soft::SoftSolidWindow;
pub use solver::Peridynamics;
