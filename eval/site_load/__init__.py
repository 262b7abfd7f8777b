"""How the questionnaire site bears a crowd: `python -m eval.site_load BATCH -o REPORT`."""
