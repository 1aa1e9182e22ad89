//! What is wrong with an option: the same shape for every kind of database.

use std::fmt;

/// One thing wrong with the options.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OptionFault {
    /// The option's name.
    pub option: &'static str,
    /// What is wrong, and what would be right.
    pub message: String,
}

impl fmt::Display for OptionFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.option, self.message)
    }
}
