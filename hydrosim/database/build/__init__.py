"""Making a database from a hull, by Capytaine (the extra ``bem``); nothing of it is imported
elsewhere."""
