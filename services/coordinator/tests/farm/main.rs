//! The coordinator's service against submitters that mean harm, and the roles of its users.

mod hostile;
mod loading;
mod roles;
