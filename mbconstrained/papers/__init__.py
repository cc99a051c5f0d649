"""The closed forms that the papers print, corrected: views for study and comparison, on no road from a problem to its answer.

May import ``exact`` and the rooms below it. ``matrix_exponentials`` has Lemmas 2.11-2.13 of Moysis et al., ``corollaries`` the free
motions of Corollaries 4.2-4.4 that follow from them, ``apostol_kolodner`` the special form of section 4.2;
``residue_form`` has the modal sums of Hauksdottir and Sigurdsson, ``normal_form_rows`` the transformations of Mayet.
"""
