"""Plain tables from files. Read ``reading``, then ``includes``; ``messages`` knows the location of every entry."""
