"""Reports of a comparison: html for people, json for machines."""
