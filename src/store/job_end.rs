//! How jobs end, whichever database keeps them.

/// How a job ends.
#[derive(Debug, Default)]
pub struct Outcome<'a> {
    pub version: Option<i64>,
    pub problem: Option<&'a str>,
    pub comparison: Option<&'a str>,
}

/// What a job is about.
#[derive(Debug, Clone, Copy)]
pub enum Subject<'a> {
    Database(&'a str),
    Calibration(&'a str),
}

impl<'a> Subject<'a> {
    /// The database, if the job is about one.
    pub fn database(self) -> Option<&'a str> {
        match self {
            Self::Database(name) => Some(name),
            Self::Calibration(_) => None,
        }
    }

    /// The calibration, if the job is about one.
    pub fn calibration(self) -> Option<&'a str> {
        match self {
            Self::Database(_) => None,
            Self::Calibration(name) => Some(name),
        }
    }

    /// The problem (JSON) of a job whose subject was deleted.
    pub fn deleted(self) -> String {
        let (code, detail) = match self {
            Self::Database(name) => ("database_deleted", format!("database {name:?} was deleted")),
            Self::Calibration(name) => ("calibration_deleted", format!("calibration {name:?} was deleted")),
        };
        serde_json::json!({"code": code, "detail": detail}).to_string()
    }
}

/// The problem (JSON) of a job that was claimed as often as it may be.
pub fn attempts_exhausted(attempts: u32) -> String {
    let detail = format!("the job was taken up {attempts} times and never finished");
    serde_json::json!({"code": "attempts_exhausted", "detail": detail}).to_string()
}
